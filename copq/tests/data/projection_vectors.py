#!/usr/bin/env python3
"""High-precision reference vectors for the multi-objective confidence bounds of COP-Q.

Every expected number is computed with 80 significant digits (mpmath) from the float32 inputs that the file stores
exactly, by the textbook definitions (not by any fast path), and printed as the nearest float64.

    python3 projection_vectors.py 20261122 projection_vectors.json
"""
import json, random, struct, sys
from mpmath import mp, mpf, matrix, sqrt, eigsy

mp.dps = 80


def f32(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def moments(q):
    e, n = len(q), len(q[0])
    mean = [sum(q[i][k] for i in range(e)) / e for k in range(n)]
    cov = matrix(n, n)
    for a in range(n):
        for b in range(n):
            cov[a, b] = sum((q[i][a] - mean[a]) * (q[i][b] - mean[b]) for i in range(e)) / e
    return mean, cov


def cholesky(cov, n, scale):
    """Semidefinite Cholesky: a pivot that is zero (relative to the exact arithmetic) gives a zero column."""
    low = matrix(n, n)
    tiny = mpf(10) ** -60 * max(scale, mpf(10) ** -300)
    for j in range(n):
        d = cov[j, j] - sum(low[j, k] ** 2 for k in range(j))
        if d <= tiny:
            continue
        low[j, j] = sqrt(d)
        for i in range(j + 1, n):
            low[i, j] = (cov[i, j] - sum(low[i, k] * low[j, k] for k in range(j))) / low[j, j]
    return low


def eigen(cov, n, scale):
    if n == 1:
        m = matrix(1, 1)
        m[0, 0] = sqrt(cov[0, 0])
        return m
    w, v = eigsy(cov)
    d = matrix(n, n)
    for i in range(n):
        d[i, i] = sqrt(w[i]) if w[i] > 0 else mpf(0)
    return v * d * v.T


def extremum(cov, u, n):
    s = sum(u[a] * cov[a, b] * u[b] for a in range(n) for b in range(n))
    if s <= 0:
        return matrix(n, n)
    return cov / sqrt(s)


def diagonal(cov, n):
    m = matrix(n, n)
    for i in range(n):
        m[i, i] = sqrt(cov[i, i])
    return m


def clip(c, u, n):
    """R u by the Rodrigues matrix of Appendix A (K, K^2 formed explicitly)."""
    p = [sum(c[b, a] * u[b] for b in range(n)) for a in range(n)]
    a = sum(u[i] * p[i] for i in range(n))
    if a >= 0:
        return u, False
    rho2 = sum(x * x for x in p)
    rho = sqrt(rho2)
    s = sqrt(rho2 - a * a)
    v = [(p[i] - a * u[i]) / s for i in range(n)]
    k = matrix(n, n)
    for i in range(n):
        for j in range(n):
            k[i, j] = v[i] * u[j] - u[i] * v[j]
    r = matrix(n, n)
    for i in range(n):
        r[i, i] = 1
    r = r - (a / rho) * k + (1 - sqrt(1 - a * a / rho2)) * (k * k)
    return [sum(r[i, j] * u[j] for j in range(n)) for i in range(n)], True


METHODS = ("cholesky", "eigen", "extremum", "diagonal")


def offset(method, q, u):
    n = len(u)
    mean, cov = moments(q)
    scale = max(cov[i, i] for i in range(n))
    c = {"cholesky": lambda: cholesky(cov, n, scale), "eigen": lambda: eigen(cov, n, scale),
         "extremum": lambda: extremum(cov, u, n), "diagonal": lambda: diagonal(cov, n)}[method]()
    ru, clipped = clip(c, u, n) if method == "cholesky" else (u, False)
    return mean, [sum(c[i, j] * ru[j] for j in range(n)) for i in range(n)], clipped


def total_lower(method, q, u):
    mean, off, _ = offset(method, q, u)
    return sum(u[i] * (mean[i] - off[i]) for i in range(len(u)))


def weighted_lower(method, q, u, w):
    mean, off, _ = offset(method, q, u)
    return sum(w[i] * (mean[i] - off[i]) for i in range(len(u)))


def gradient(method, q, u, w):
    """d(w . lower)/dq by central differences in 80 digits: exact to far more than float64."""
    h = mpf(10) ** -25
    rows = []
    for i in range(len(q)):
        row = []
        for k in range(len(u)):
            hold = q[i][k]
            q[i][k] = hold + h
            up = weighted_lower(method, q, u, w)
            q[i][k] = hold - h
            down = weighted_lower(method, q, u, w)
            q[i][k] = hold
            row.append(float((up - down) / (2 * h)))
        rows.append(row)
    return rows


def case(name, q, u, beta, rng, with_grad):
    n = len(u)
    q = [[f32(x) for x in row] for row in q]
    u = [f32(x) for x in u]
    w = [f32(rng.gauss(0, 1)) for _ in range(n)]
    qm = [[mpf(x) for x in row] for row in q]
    raw = [mpf(x) for x in u]
    norm = sqrt(sum(x * x for x in raw))
    um = [x / norm for x in raw]
    wm = [mpf(x) for x in w]
    mean, cov = moments(qm)
    out = {"name": name, "n": n, "e": len(q), "u_raw": u, "u": [float(x) for x in um], "beta": beta, "w": w, "q": q,
           "mean": [float(x) for x in mean], "cov": [[float(cov[i, j]) for j in range(n)] for i in range(n)], "expect": {}}
    for m in METHODS:
        _, off, clipped = offset(m, qm, um)
        b = mpf(beta)
        row = {"clipped": clipped,
               "lower": [float(mean[i] - off[i]) for i in range(n)],
               "upper": [float(mean[i] + b * off[i]) for i in range(n)]}
        if with_grad:
            row["grad_w_lower"] = gradient(m, qm, um, wm)
        out["expect"][m] = row
    return out


def main(seed, path):
    rng = random.Random(seed)
    g = rng.gauss
    cases = []

    def draw(n, e, scale=1.0, shift=0.0):
        mix = [[g(0, 1) for _ in range(n)] for _ in range(n)]
        rows = []
        for _ in range(e):
            z = [g(0, 1) for _ in range(n)]
            rows.append([shift + scale * sum(mix[a][b] * z[b] for b in range(n)) for a in range(n)])
        return rows

    for i in range(12):
        a, b = g(0, 10), g(0, 10)
        cases.append(case(f"n1-clipped-double-q-{i}", [[a], [b]], [1.0], 1.0, rng, True))
    for n in (2, 3, 5):
        for i in range(10):
            u = [g(0, 1) for _ in range(n)]
            cases.append(case(f"n{n}-generic-{i}", draw(n, n + 1), u, abs(g(2, 2)), rng, True))
    for i in range(6):
        cases.append(case(f"n3-ten-critics-{i}", draw(3, 10, 5.0, 100.0), [1, 1, 1], 4.66, rng, True))
    # clipping: strongly negatively correlated objectives of very different scales
    made = 0
    while made < 12:
        t = [g(0, 1) for _ in range(4)]
        q = [[0.05 * x + 0.01 * g(0, 1), -5.0 * x + 0.05 * g(0, 1)] for x in t]
        u = [abs(g(0, 1)) + 0.05, abs(g(0, 1)) + 0.05]
        c = case(f"n2-clip-{made}", q, u, 2.0, rng, True)
        if c["expect"]["cholesky"]["clipped"]:
            cases.append(c)
            made += 1
    made = 0
    while made < 8:
        t = [g(0, 1) for _ in range(4)]
        q = [[0.05 * x + 0.01 * g(0, 1), -5.0 * x + 0.05 * g(0, 1), 0.3 * x + 0.2 * g(0, 1)] for x in t]
        u = [abs(g(0, 1)) + 0.05 for _ in range(3)]
        c = case(f"n3-clip-{made}", q, u, 2.0, rng, True)
        if c["expect"]["cholesky"]["clipped"]:
            cases.append(c)
            made += 1
    # constrained RL: cost first, u = (-lambda, 1)
    for i, lam in enumerate((0.0, 0.01, 0.5, 1.0, 10.0, 1000.0)):
        cases.append(case(f"cost-first-lambda-{i}", draw(2, 3, 20.0, 150.0), [-lam, 1.0], 1.0, rng, True))
    # ill conditioned: nearly colinear deviations, the case the paper warns about in float32
    for i, eps in enumerate((1e-1, 1e-2, 1e-3, 1e-4)):
        for n in (2, 3):
            t = [g(0, 1) for _ in range(n + 1)]
            q = [[(1.0 + 0.3 * k) * x + eps * g(0, 1) for k in range(n)] for x in t]
            cases.append(case(f"n{n}-colinear-1e-{i+1}", q, [1.0] * n, 1.0, rng, False))
    # large offset, small spread: cancellation in the covariance
    for i, shift in enumerate((1e2, 1e3, 1e4)):
        cases.append(case(f"n3-shift-{i}", draw(3, 4, 0.5, shift), [1, 1, 1], 1.0, rng, False))
    # tiny and huge scales
    for i, s in enumerate((1e-12, 1e-6, 1e6, 1e12)):
        cases.append(case(f"n3-scale-{i}", draw(3, 4, s), [1, 2, 3], 1.0, rng, False))
    # exact degeneracies
    cases.append(case("all-equal", [[3.0, -2.0, 7.0]] * 4, [1, 1, 1], 2.0, rng, False))
    cases.append(case("first-objective-certain", [[5.0, 1.0], [5.0, 2.0], [5.0, 4.0]], [1, 1], 2.0, rng, False))
    cases.append(case("last-objective-certain", [[1.0, 5.0], [2.0, 5.0], [4.0, 5.0]], [1, 1], 2.0, rng, False))
    cases.append(case("rank-one-two-critics", [[1.0, 2.0, 3.0], [2.0, 4.0, 1.0]], [1, 1, 1], 2.0, rng, False))
    cases.append(case("rank-one-colinear", [[1.0, 2.0], [2.0, 4.0], [4.0, 8.0]], [1, 1], 2.0, rng, False))
    for n, e in ((10, 11), (10, 40), (20, 21), (50, 51), (50, 200)):
        cases.append(case(f"n{n}-e{e}", draw(n, e), [g(0, 1) for _ in range(n)], 1.0, rng, False))
    json.dump({"about": "q: critics x objectives, exact float32; u: unit direction of u_raw; lower = mean - C R u; "
                        "upper = mean + beta C R u; grad_w_lower = d(w . lower)/dq, u held fixed",
               "seed": seed, "cases": cases}, open(path, "w"), separators=(",", ":"))
    print(len(cases), "cases")


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
