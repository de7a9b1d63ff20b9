/* Counts what each thread asks of the C allocator and tells it on standard error when the thread ends: `allocations NAME COUNT`.
 * Preloaded into the host; libusb's allocations are in C, out of sight of a counting allocator in Rust. The C library of Debian. */
#define _GNU_SOURCE
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);

static __thread unsigned long count __attribute__((tls_model("initial-exec")));
static __thread int watched __attribute__((tls_model("initial-exec")));
static pthread_key_t key;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void thread_ends(void *unused) {
    char name[17] = "", line[64];
    (void)unused;
    prctl(PR_GET_NAME, name);
    int length = snprintf(line, sizeof line, "allocations %s %lu\n", name, count);
    if (write(2, line, (size_t)length) < 0)
        return;
}

static void make_key(void) { pthread_key_create(&key, thread_ends); }

static void counted(void) {
    count++;
    if (!watched) {
        watched = 1;
        pthread_once(&once, make_key);
        pthread_setspecific(key, "");
    }
}

void *malloc(size_t n) {
    counted();
    return __libc_malloc(n);
}

void *calloc(size_t n, size_t m) {
    counted();
    return __libc_calloc(n, m);
}

void *realloc(void *p, size_t n) {
    counted();
    return __libc_realloc(p, n);
}
