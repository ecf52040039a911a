/* Lets the N-th change of a file under a folder fail, as a full or dying disk does. For scripts/torture.sh; Linux.
 *
 *   cc -shared -fPIC -o faults.so faults.c -ldl
 *   FAULT_DIR=/tmp/run FAULT_AT=17 FAULT_KIND=enospc LD_PRELOAD=./faults.so copq train ...
 *
 * Kinds: enospc (this write and all after it), eio (this call alone), short (half of this write is done, the next one
 * fails for want of room), torn (half of this write is done, then the process is gone), rename (renames are refused).
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static long calls;

static int is_kind(const char *kind) {
    const char *wanted = getenv("FAULT_KIND");
    return wanted && strcmp(wanted, kind) == 0;
}

static int is_path_ours(const char *path) {
    const char *folder = getenv("FAULT_DIR");
    return folder && path && strncmp(path, folder, strlen(folder)) == 0;
}

static int is_ours(int fd) {
    char name[64], path[4096];
    snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(name, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return is_path_ours(path);
}

/* Counts a change, or of kind rename a rename; positive when it is the chosen one, 2 and more when it comes after. */
static long due(int is_rename) {
    const char *at = getenv("FAULT_AT");
    if (!at || (is_kind("rename") && !is_rename)) return 0;
    long after = __sync_add_and_fetch(&calls, 1) - atol(at);
    return after < 0 ? 0 : after + 1;
}

static int fails(long now, int is_write) {
    if (!now) return 0;
    if (is_kind("enospc") && is_write) { errno = ENOSPC; return 1; }
    if (is_kind("eio") && now == 1) { errno = EIO; return 1; }
    if (is_kind("short") && is_write && now > 1) { errno = ENOSPC; return 1; }
    return 0;
}

ssize_t write(int fd, const void *bytes, size_t count) {
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "write");
    if (!is_ours(fd)) return real(fd, bytes, count);
    long now = due(0);
    if (fails(now, 1)) return -1;
    if (now == 1 && (is_kind("short") || is_kind("torn"))) {
        ssize_t done = real(fd, bytes, count / 2);
        if (is_kind("torn")) _exit(137);
        return done;
    }
    return real(fd, bytes, count);
}

#define SYNC(name)                                         \
    int name(int fd) {                                     \
        static int (*real)(int);                           \
        if (!real) *(void **)&real = dlsym(RTLD_NEXT, #name); \
        return is_ours(fd) && fails(due(0), 0) ? -1 : real(fd); \
    }
SYNC(fsync)
SYNC(fdatasync)

int rename(const char *from, const char *to) {
    static int (*real)(const char *, const char *);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "rename");
    if (!is_path_ours(to)) return real(from, to);
    long now = due(1);
    if (now == 1 && is_kind("rename")) { errno = EACCES; return -1; }
    return fails(now, 0) ? -1 : real(from, to);
}

/* Other changes of a folder's names, and copies that never leave the kernel. */
int link(const char *from, const char *to) {
    static int (*real)(const char *, const char *);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "link");
    return is_path_ours(to) && fails(due(0), 1) ? -1 : real(from, to);
}

int linkat(int from_fd, const char *from, int to_fd, const char *to, int flags) {
    static int (*real)(int, const char *, int, const char *, int);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "linkat");
    return is_path_ours(to) && fails(due(0), 1) ? -1 : real(from_fd, from, to_fd, to, flags);
}

int unlink(const char *path) {
    static int (*real)(const char *);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "unlink");
    return is_path_ours(path) && fails(due(0), 0) ? -1 : real(path);
}

ssize_t copy_file_range(int from, off64_t *from_at, int to, off64_t *to_at, size_t count, unsigned flags) {
    static ssize_t (*real)(int, off64_t *, int, off64_t *, size_t, unsigned);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "copy_file_range");
    return is_ours(to) && fails(due(0), 1) ? -1 : real(from, from_at, to, to_at, count, flags);
}

#define OPEN(name)                                                             \
    int name(const char *path, int flags, ...) {                               \
        static int (*real)(const char *, int, ...);                            \
        if (!real) *(void **)&real = dlsym(RTLD_NEXT, #name);                  \
        va_list more;                                                          \
        va_start(more, flags);                                                 \
        mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;              \
        va_end(more);                                                          \
        if ((flags & O_CREAT) && is_path_ours(path) && fails(due(0), 1)) return -1; \
        return real(path, flags, mode);                                        \
    }
OPEN(open)
OPEN(open64)
