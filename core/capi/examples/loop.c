/* A haptic loop as CHAI3D's programs have one, with haptor in place of the finger-proxy force: a thread of its own, a thousand times a
 * second read the device, step the core, write force and torque. CHAI3D is not needed to build this: the device is a struct of functions
 * (section 1). A stub fills it here; whoever has CHAI3D fills it with its calls (core/capi/README.md shows how, in C++).
 *
 *   cc -std=c11 -Wall -Wextra -Werror -pedantic -I core/capi/include core/capi/examples/loop.c \
 *      target/release/libhaptor_capi.a -lpthread -lm -ldl -o loop
 *   ./loop MODEL [TICKS]
 *
 * Prints one line a tick: seven numbers of the pose, dt, six of the wrench, each as the hexadecimal digits of its 32 bits. */
#define _XOPEN_SOURCE 700

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "haptor.h"

/* ---- 1. A device ---- */

/* What a haptic device can do: what the loop needs of CHAI3D's cGenericHapticDevice. Each function answers 0 when it went well. */
struct haptic_device {
    void *self;
    double max_force;  /* [N] */
    double max_torque; /* [N m], 0 = none */
    /* position [m] and rotation matrix, row by row, of the handle in the device's base */
    int (*get_transform)(void *self, double position[3], double rotation[9]);
    int (*set_force_and_torque)(void *self, const double force[3], const double torque[3]);
};

/* A stub: goes down to the object 5 mm below its start, 0.4 mm into it, and turns there; keeps the last force it was given. */
struct stub {
    unsigned ticks;
    double force[3], torque[3];
};

static double between(double x, double from, double to)
{
    double s = (x - from) / (to - from);
    return s < 0 ? 0 : s > 1 ? 1 : s;
}

static int stub_transform(void *self, double position[3], double rotation[9])
{
    struct stub *stub = self;
    double t = stub->ticks++ / 1000.0, angle = 0.5 * between(t, 0.6, 1.2);
    double c = cos(angle), s = sin(angle);
    double turned[9] = { c, -s, 0, s, c, 0, 0, 0, 1 };
    memcpy(rotation, turned, sizeof turned);
    position[0] = 2e-3 * between(t, 1.3, 1.8);
    position[1] = 0;
    position[2] = -5.4e-3 * between(t, 0.0, 0.5);
    return 0;
}

static int stub_force(void *self, const double force[3], const double torque[3])
{
    struct stub *stub = self;
    memcpy(stub->force, force, sizeof stub->force);
    memcpy(stub->torque, torque, sizeof stub->torque);
    return 0;
}

/* ---- 2. The loop ---- */

/* One tick as it was. */
struct tick {
    haptor_pose pose;
    float dt;
    haptor_wrench wrench;
};

struct loop {
    struct haptic_device *device;
    haptor *core;
    atomic_bool stop;
    struct tick *log; /* room for `ticks` */
    unsigned ticks, done;
    unsigned refused, device_errors, late;
};

/* Unit quaternion (w, x, y, z) of a rotation matrix: the largest of its parts first, the others from it (Shepperd 1978). */
static void quaternion_of(const double m[9], float q[4])
{
    double trace[4] = { m[0] + m[4] + m[8], m[0] - m[4] - m[8], m[4] - m[0] - m[8], m[8] - m[0] - m[4] };
    int k = 0;
    for (int i = 1; i < 4; i++)
        if (trace[i] > trace[k])
            k = i;
    double part[4], big = sqrt(1 + trace[k]);
    double sums[4][4] = {
        { big * big, m[7] - m[5], m[2] - m[6], m[3] - m[1] },
        { m[7] - m[5], big * big, m[1] + m[3], m[2] + m[6] },
        { m[2] - m[6], m[1] + m[3], big * big, m[5] + m[7] },
        { m[3] - m[1], m[2] + m[6], m[5] + m[7], big * big },
    };
    for (int i = 0; i < 4; i++)
        part[i] = 0.5 * sums[k][i] / big;
    for (int i = 0; i < 4; i++)
        q[i] = (float)part[i];
}

/* One turn of the loop: what CHAI3D's updateHaptics() does between two of its lines. */
static void turn(struct loop *l, float dt)
{
    struct haptic_device *device = l->device;
    double position[3], rotation[9], force[3] = { 0 }, torque[3] = { 0 };
    struct tick tick = { .dt = dt };
    if (device->get_transform(device->self, position, rotation) == 0) {
        for (int i = 0; i < 3; i++)
            tick.pose.position[i] = (float)position[i];
        quaternion_of(rotation, tick.pose.rotation);
        int32_t answer = haptor_step(l->core, &tick.pose, dt, &tick.wrench, NULL);
        l->refused += answer != HAPTOR_OK;
        for (int i = 0; i < 3 && answer == HAPTOR_OK; i++) {
            force[i] = (double)tick.wrench.force[i];
            torque[i] = (double)tick.wrench.torque[i];
        }
    } else {
        l->device_errors++;
    }
    /* whatever went wrong, the device hears zero and not what it heard last */
    l->device_errors += device->set_force_and_torque(device->self, force, torque) != 0;
    l->log[l->done++] = tick;
}

/* The haptic thread. dt is the period and not what the clock says: the same poses give the same forces. */
static void *haptics(void *argument)
{
    const long period_ns = 1000000;
    struct loop *l = argument;
    struct timespec next, now;
    clock_gettime(CLOCK_MONOTONIC, &next);
    while (!atomic_load(&l->stop) && l->done < l->ticks) {
        turn(l, 1e-3f);
        next.tv_nsec += period_ns;
        next.tv_sec += next.tv_nsec / 1000000000;
        next.tv_nsec %= 1000000000;
        clock_gettime(CLOCK_MONOTONIC, &now);
        l->late += now.tv_sec > next.tv_sec || (now.tv_sec == next.tv_sec && now.tv_nsec > next.tv_nsec);
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
    }
    return NULL;
}

/* ---- 3. A program ---- */

static haptor *open_model(const char *path)
{
    char error[256];
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) {
        perror(path);
        exit(1);
    }
    long size = ftell(file);
    rewind(file);
    void *bytes = malloc(size > 0 ? (size_t)size : 1);
    size_t length = bytes ? fread(bytes, 1, (size_t)size, file) : 0;
    fclose(file);
    haptor *core = haptor_open(bytes, length, error, sizeof error);
    free(bytes);
    if (core == NULL) {
        fprintf(stderr, "%s: %s\n", path, error);
        exit(2);
    }
    return core;
}

static void print(const struct tick *tick)
{
    float numbers[14];
    memcpy(numbers, tick->pose.position, sizeof tick->pose.position);
    memcpy(numbers + 3, tick->pose.rotation, sizeof tick->pose.rotation);
    numbers[7] = tick->dt;
    memcpy(numbers + 8, tick->wrench.force, sizeof tick->wrench.force);
    memcpy(numbers + 11, tick->wrench.torque, sizeof tick->wrench.torque);
    for (int i = 0; i < 14; i++) {
        unsigned long word;
        uint32_t bits;
        memcpy(&bits, &numbers[i], sizeof bits);
        word = bits;
        printf("%08lx%c", word, i == 13 ? '\n' : ' ');
    }
}

int main(int argc, char **argv)
{
    if (argc < 2 || haptor_abi() != HAPTOR_ABI) {
        fprintf(stderr, "usage: loop MODEL [TICKS]; header %d, library %lu\n", HAPTOR_ABI, (unsigned long)haptor_abi());
        return 2;
    }
    struct stub stub = { 0 };
    struct haptic_device device = { &stub, 8.5, 0.188, stub_transform, stub_force };
    struct loop loop = { .device = &device, .core = open_model(argv[1]) };
    loop.ticks = argc > 2 ? (unsigned)strtoul(argv[2], NULL, 10) : 2000;
    loop.log = calloc(loop.ticks > 0 ? loop.ticks : 1, sizeof *loop.log);
    pthread_t thread;
    if (loop.log == NULL || haptor_fit(loop.core, (float)device.max_force, (float)device.max_torque) != HAPTOR_OK)
        return 1;
    if (pthread_create(&thread, NULL, haptics, &loop) != 0)
        return 1;
    pthread_join(thread, NULL);
    haptor_close(loop.core);
    for (unsigned i = 0; i < loop.done; i++)
        print(&loop.log[i]);
    fprintf(stderr, "haptor %s: %u ticks, %u late, %u refused, %u device errors; last force %.3f %.3f %.3f N\n", haptor_version(),
            loop.done, loop.late, loop.refused, loop.device_errors, stub.force[0], stub.force[1], stub.force[2]);
    free(loop.log);
    return 0;
}
