/* haptor for C and C++: what a hand feels when a rigid probe presses, slides and twists on an elastic object.
 *
 * A scene is baked into a file (`haptor bake SCENE -o MODEL`); the file's bytes make a handle; the handle is stepped once a tick with
 * the pose of a haptic device's handle and says the wrench to give it. Link with libhaptor_capi.a, -lpthread, -lm, -ldl.
 *
 * Units are SI: m, N, N m, s. Frames: `d` the device's base, `h` its handle, `w` the world (base centre of the object, +z up). The
 * probe's mass centre is the handle's origin. Right-handed, quaternions are (w, x, y, z).
 *
 * Threads: different handles know nothing of each other. One handle is for one thread at a time; it may be opened in one thread and
 * stepped in another. haptor_step allocates nothing, waits for nothing, reads no clock, and cannot fail half-way.
 *
 * Stack: haptor_open and haptor_rest need 1 MiB, haptor_step 64 KiB.
 *
 * Pointers: a null or misaligned one is refused with HAPTOR_BAD_POINTER. A handle that was closed must not be used again; that cannot
 * be checked. Nothing here ever unwinds into the caller. */
#ifndef HAPTOR_H
#define HAPTOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Changes when anything below changes its meaning or its layout. Compare it with haptor_abi() at start. */
#define HAPTOR_ABI 1

/* What a function answers. */
#define HAPTOR_OK 0
#define HAPTOR_BAD_POINTER 1 /* a pointer is null or misaligned: nothing was done */
#define HAPTOR_BAD_VALUE 2   /* a value is out of its range: nothing was done */
#define HAPTOR_REFUSED 3     /* the pose is none, or a jump no hand makes: the wrench is that of the last good one, do not render it for long */
#define HAPTOR_NOT_FINITE 4  /* a result was not finite: the wrench is zero, the contact is forgotten */

/* Bits of haptor_report.flags; 0 is a clean tick. */
#define HAPTOR_FLAG_POSE_REFUSED 0x0001u
#define HAPTOR_FLAG_POSE_JUMP 0x0002u
#define HAPTOR_FLAG_REGION_REFUSED 0x0004u
#define HAPTOR_FLAG_FORCE_LIMITED 0x0008u
#define HAPTOR_FLAG_TORQUE_LIMITED 0x0010u
#define HAPTOR_FLAG_FORCE_SLEWED 0x0020u
#define HAPTOR_FLAG_TORQUE_SLEWED 0x0040u
#define HAPTOR_FLAG_RAMPING_IN 0x0080u
#define HAPTOR_FLAG_LENGTH_FLOORED 0x0100u
#define HAPTOR_FLAG_LARGE_STRAIN 0x0200u
#define HAPTOR_FLAG_NON_FINITE 0x0400u
#define HAPTOR_FLAG_TIER_LOWERED 0x0800u
#define HAPTOR_FLAG_BIRTH_WAITS 0x1000u
#define HAPTOR_FLAG_PASSIVITY_DAMPED 0x2000u
#define HAPTOR_FLAG_POSE_COARSE 0x4000u

/* haptor_report.tier. */
#define HAPTOR_TIER_POINT 0u
#define HAPTOR_TIER_PAPER 1u
#define HAPTOR_TIER_BRISTLE 2u
#define HAPTOR_TIER_INFLUENCE 3u
#define HAPTOR_TIER_GREEN 4u

/* A core at work. */
typedef struct haptor haptor;

/* A position [m] and a unit quaternion (w, x, y, z), off unit length by at most 0.001. */
typedef struct haptor_pose {
    float position[3];
    float rotation[4];
} haptor_pose;

/* A force [N] and a torque [N m]. */
typedef struct haptor_wrench {
    float force[3];
    float torque[3];
} haptor_wrench;

/* What else a tick has to say. */
typedef struct haptor_report {
    float contact_force[3];  /* on the probe, before limits, in w [N] */
    float contact_torque[3]; /* on the probe about its mass centre, before limits, in w [N m] */
    float depth;             /* largest [m]; 0 without contact */
    float radius;            /* contact radius of the deepest region [m] */
    float stick;             /* stuck share of the deepest region's area, 0 to 1 */
    uint32_t flags;          /* HAPTOR_FLAG_ bits */
    uint32_t regions;        /* in contact */
    uint32_t tier;           /* HAPTOR_TIER_ that computed this tick */
} haptor_report;

/* HAPTOR_ABI of the library. */
uint32_t haptor_abi(void);

/* The library's version in words, e.g. "0.1.0". Never null, never to be freed. */
const char *haptor_version(void);

/* Makes a core at rest from the bytes of a baked file, which are not needed afterwards.
 *
 * Null when the bytes are none, are damaged, or hold a value out of its range; then `error`, when it is not null and has room, says why,
 * cut to error_size and always ended by a zero. Allocates; may take milliseconds. */
haptor *haptor_open(const void *model, size_t length, char *error, size_t error_size);

/* Tells the core what the device renders at most [N], [N m]; 0 torque = none. Limits and a virtual coupling's open values follow; the
 * scene's own limits hold where they are lower. Without it the device is one of 8.5 N and 0.188 N m. HAPTOR_BAD_VALUE and nothing
 * changed when the force is not above 0 or a value is not finite. Between ticks, in the thread that steps. */
int32_t haptor_fit(haptor *core, float max_force, float max_torque);

/* Where the scene says that the device stands: x_wd, so that x_wp = x_wd * x_dh. */
int32_t haptor_place(const haptor *core, haptor_pose *x_wd);

/* One tick. `x_dh` is the handle's pose, `dt` the time since the last tick [s], above 0. Writes the wrench on the handle about its
 * origin, in d, after limits; `report` may be null. HAPTOR_OK, HAPTOR_BAD_POINTER, HAPTOR_REFUSED or HAPTOR_NOT_FINITE. With a bad
 * pointer nothing is written but a zero wrench, where there is a place for one. */
int32_t haptor_step(haptor *core, const haptor_pose *x_dh, float dt, haptor_wrench *wrench, haptor_report *report);

/* Forgets all contact and motion, as after haptor_open; what haptor_fit told stays. For a device that was let go and taken up again.
 * Allocates nothing. */
int32_t haptor_rest(haptor *core);

/* Frees it. Null is nothing. */
void haptor_close(haptor *core);

#ifdef __cplusplus
}
#endif

#endif
