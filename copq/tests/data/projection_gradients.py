#!/usr/bin/env python3
"""Gradients for the cases of projection_vectors.json that come without: d(w . lower)/dq in 80 digits.

Up to ten objectives by central differences of the textbook definitions, as in projection_vectors.py. From twenty on by
reverse formulas that have nothing in common with the library's: on the covariance, not on the deviations (Murray 2016
for the Cholesky factor, the Lyapunov equation for the symmetric root). Before use they are checked against the
differences, on small cases.

    python3 projection_gradients.py projection_vectors.json projection_gradients.json
"""
import json
import sys

from mpmath import eigsy, inverse, matrix, mpf, sqrt

from projection_vectors import METHODS, cholesky, clip, gradient, moments

# No derivative, not even the middle of two sides: the offset jumps where an objective of higher priority is certain.
JUMPS = {("first-objective-certain", "cholesky")}
# Ten thousand entries a method: the two that are not elementary are enough.
LARGE = {"n50-e200": ("cholesky", "eigen")}


def bar_cholesky(cov, u, w):
    """d(w . L u)/dSigma, symmetric, where the clip does not fire."""
    n = len(u)
    low = cholesky(cov, n, max(cov[i, i] for i in range(n)))
    assert not clip(low, u, n)[1]
    bar = matrix(n, n)
    for i in range(n):
        for j in range(i + 1):
            bar[i, j] = w[i] * u[j]
    phi = low.T * bar
    for i in range(n):
        phi[i, i] /= 2
        for j in range(i + 1, n):
            phi[i, j] = 0
    inv = inverse(low)
    out = inv.T * phi * inv
    return (out + out.T) / 2


def bar_eigen(cov, u, w):
    """d(w . Sigma^(1/2) u)/dSigma: P with P S + S P = (w u' + u w') / 2."""
    n = len(u)
    values, v = eigsy(cov)
    s = [sqrt(x) if x > 0 else mpf(0) for x in values]
    wv = [sum(v[a, i] * w[a] for a in range(n)) for i in range(n)]
    uv = [sum(v[a, i] * u[a] for a in range(n)) for i in range(n)]
    p = matrix(n, n)
    for i in range(n):
        for j in range(n):
            p[i, j] = (wv[i] * uv[j] + uv[i] * wv[j]) / 2 / (s[i] + s[j])
    return v * p * v.T


def bar_extremum(cov, u, w):
    n = len(u)
    su = [sum(cov[a, b] * u[b] for b in range(n)) for a in range(n)]
    square = sum(u[a] * su[a] for a in range(n))
    ws = sum(w[a] * su[a] for a in range(n))
    bar = matrix(n, n)
    for a in range(n):
        for b in range(n):
            bar[a, b] = (w[a] * u[b] + u[a] * w[b]) / 2 / sqrt(square) - ws * u[a] * u[b] / 2 / square ** mpf("1.5")
    return bar


def bar_diagonal(cov, u, w):
    n = len(u)
    bar = matrix(n, n)
    for a in range(n):
        bar[a, a] = w[a] * u[a] / 2 / sqrt(cov[a, a])
    return bar


BARS = {"cholesky": bar_cholesky, "eigen": bar_eigen, "extremum": bar_extremum, "diagonal": bar_diagonal}


def analytic(method, q, u, w):
    """d(w . lower)/dq = w / K - (2 / K) X dL/dSigma."""
    k, n = len(q), len(u)
    mean, cov = moments(q)
    bar = BARS[method](cov, u, w)
    x = matrix(k, n)
    for a in range(k):
        for b in range(n):
            x[a, b] = q[a][b] - mean[b]
    out = x * bar
    return [[w[b] / k - 2 * out[a, b] / k for b in range(n)] for a in range(k)]


def inputs(case):
    u = [mpf(x) for x in case["u_raw"]]
    norm = sqrt(sum(x * x for x in u))
    return [[mpf(x) for x in row] for row in case["q"]], [x / norm for x in u], [mpf(x) for x in case["w"]]


def check(case, method):
    """The reverse formulas agree with central differences."""
    formula = analytic(method, *inputs(case))
    for row, known in zip(formula, case["expect"][method]["grad_w_lower"]):
        assert all(abs(a - b) < 1e-12 * (1 + abs(b)) for a, b in zip(row, known)), (case["name"], method)


def main(vectors, path):
    cases = json.load(open(vectors))["cases"]
    for case in cases:
        if case["name"].startswith(("n3-generic", "n5-generic")):
            for method in METHODS:
                if not case["expect"][method]["clipped"]:
                    check(case, method)
    out = {}
    for case in cases:
        if "grad_w_lower" in case["expect"]["cholesky"]:
            continue
        known = out[case["name"]] = {}
        for method in LARGE.get(case["name"], METHODS):
            if (case["name"], method) in JUMPS:
                continue
            rule = gradient if case["n"] <= 10 else analytic
            # Nine digits are five more than the tests ask for.
            known[method] = [[float("%.9g" % x) for x in map(float, row)] for row in rule(method, *inputs(case))]
            print(case["name"], method, flush=True)
    json.dump(out, open(path, "w"), separators=(",", ":"))


main(sys.argv[1], sys.argv[2])
