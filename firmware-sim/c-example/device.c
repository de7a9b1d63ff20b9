/* A haptic device in one file of C: the device's end of the link that core/wire/WIRE.md tells byte by byte, written from that text
 * alone. For whoever writes firmware: sections 1 to 3 go into a microcontroller as they are, section 4 is what its sensors would say,
 * section 5 what its UART would do.
 *
 *   cc -std=c11 -O2 -Wall -Wextra -Werror -pedantic device.c -o device
 *   ./device                   makes a pseudo-terminal and says where: serving pty /dev/pts/3
 *   ./device /dev/ttyGS0       serves a serial port, e.g. that of a USB gadget
 *
 * The handle rides on rails: it goes down, presses, turns, slides and lifts, whatever the wrench is. Units are in the names; "rule n"
 * is rule n of section 6 of WIRE.md. Needs POSIX and nothing else. */
#define _XOPEN_SOURCE 700

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

/* ---- 1. From values to bytes and back ---- */

enum {
    CRC_BYTES = 4,
    PLAIN_MAX = 58,            /* longest message with its checksum */
    FRAME_MAX = PLAIN_MAX + 2, /* one code of COBS before, one zero after */
};

/* CRC-32/ISO-HDLC, bit by bit; a table of 256 words is eight times as fast. */
static uint32_t crc32(const uint8_t *bytes, size_t n)
{
    uint32_t crc = UINT32_MAX;
    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

/* A message being written. What does not fit is left out; no message of the link is that long. */
struct writer {
    uint8_t bytes[PLAIN_MAX];
    size_t n;
};

static void put_byte(struct writer *w, uint8_t byte)
{
    if (w->n < sizeof w->bytes)
        w->bytes[w->n++] = byte;
}

static void put_unsigned(struct writer *w, uint32_t value)
{
    for (; value >= 0x80; value >>= 7)
        put_byte(w, (uint8_t)(value | 0x80));
    put_byte(w, (uint8_t)value);
}

static void put_signed(struct writer *w, int32_t value)
{
    put_unsigned(w, ((uint32_t)value << 1) ^ (value < 0 ? UINT32_MAX : 0));
}

/* Appends the checksum, stuffs, ends with a zero; yields the length of the frame. */
static size_t finish_frame(struct writer *w, uint8_t frame[FRAME_MAX])
{
    uint32_t crc = crc32(w->bytes, w->n);
    for (int i = 0; i < CRC_BYTES; i++)
        put_byte(w, (uint8_t)(crc >> 8 * i));
    size_t code_at = 0, n = 1;
    for (size_t i = 0; i < w->n; i++) {
        if (w->bytes[i] != 0) {
            frame[n++] = w->bytes[i];
            continue;
        }
        frame[code_at] = (uint8_t)(n - code_at);
        code_at = n++;
    }
    frame[code_at] = (uint8_t)(n - code_at);
    frame[n++] = 0;
    return n;
}

/* A message being read. Once anything was wrong it is bad. */
struct reader {
    const uint8_t *at, *end;
    bool bad;
};

static uint32_t take_unsigned(struct reader *r, int bits)
{
    uint32_t value = 0;
    for (int shift = 0; shift < bits && r->at < r->end; shift += 7) {
        uint8_t byte = *r->at++;
        /* in the last byte nothing beyond the type, and no "more follows" */
        if (bits - shift < 7 && byte >> (bits - shift))
            break;
        value |= (uint32_t)(byte & 0x7F) << shift;
        if (!(byte & 0x80))
            return value;
    }
    r->bad = true;
    return 0;
}

static int32_t take_signed(struct reader *r)
{
    uint32_t z = take_unsigned(r, 32);
    return z & 1 ? -(int32_t)(z >> 1) - 1 : (int32_t)(z >> 1);
}

/* Takes the stuffing out of a frame without its zero, in place; yields the length, 0 when it is not COBS. */
static size_t unstuff(uint8_t *frame, size_t n)
{
    size_t read = 0, write = 0;
    while (read < n) {
        size_t code = frame[read++];
        if (code == 0 || code - 1 > n - read)
            return 0;
        for (size_t i = 1; i < code; i++)
            frame[write++] = frame[read++];
        if (code < 0xFF && read < n)
            frame[write++] = 0;
    }
    return write;
}

/* ---- 2. Messages ---- */

#define SCHEMA 0xd4216b28u
enum { VERSION = 1 };

enum mode { RESET, IDLE, FORCE, BRAKE, MODES };
enum cause { WATCHDOG, OVER_SPEED, NON_FINITE, VERSION_MISMATCH, OUT_OF_TURN };
enum from_host { HOST_HELLO, SET_MODE, WRENCH };
enum to_host { DEVICE_HELLO, POSE_REPORT, DEVICE_FAULT };
enum flag { NO_TORQUE = 1, FORCE_CUT = 2, TORQUE_CUT = 4, TOO_FAST = 8, STARVED = 16 };

/* What the host said. */
struct order {
    uint32_t kind;
    uint32_t version, schema, period_us;         /* HOST_HELLO */
    uint32_t mode;                               /* SET_MODE */
    uint32_t seq, echo, hold_us;                 /* WRENCH */
    int32_t force_un[3], torque_unm[3];
};

/* Reads a frame without its zero; false when it is damaged or says nothing that is in the table. */
static bool read_order(uint8_t *frame, size_t n, struct order *order)
{
    n = unstuff(frame, n);
    if (n < CRC_BYTES + 1)
        return false;
    n -= CRC_BYTES;
    uint32_t crc = 0;
    for (int i = 0; i < CRC_BYTES; i++)
        crc |= (uint32_t)frame[n + (size_t)i] << 8 * i;
    if (crc != crc32(frame, n))
        return false;
    struct reader r = { frame, frame + n, false };
    memset(order, 0, sizeof *order);
    order->kind = take_unsigned(&r, 32);
    switch (order->kind) {
    case HOST_HELLO:
        order->version = take_unsigned(&r, 16);
        order->schema = take_unsigned(&r, 32);
        order->period_us = take_unsigned(&r, 32);
        break;
    case SET_MODE:
        order->mode = take_unsigned(&r, 32);
        r.bad |= order->mode >= MODES;
        break;
    case WRENCH:
        order->seq = take_unsigned(&r, 32);
        order->echo = take_unsigned(&r, 32);
        for (int i = 0; i < 3; i++)
            order->force_un[i] = take_signed(&r);
        for (int i = 0; i < 3; i++)
            order->torque_unm[i] = take_signed(&r);
        order->hold_us = take_unsigned(&r, 32);
        break;
    default:
        return false;
    }
    return !r.bad && r.at == r.end;
}

/* ---- 3. What the firmware decides ---- */

enum {
    TICK_US = 125,
    PERIOD_US = 1000,           /* of reports, unless the host asks for another */
    LONGEST_PERIOD_US = 100000,
    FADE_TICKS = 80,            /* 10 ms */
    SESSION_TICKS = 8000,       /* 1 s */
    TEXT = 12,                  /* bytes of a name */
    OUT_BYTES = 4096,           /* some 70 reports wait for a host that does not read */
};

/* What the device is, and where its limits lie. */
struct limits {
    char name[TEXT + 1], serial[TEXT + 1];
    uint32_t version, max_force_un, max_torque_unm, watchdog_ticks, over_speed_um_s, over_spin_urad_s;
};

/* What the sensors say. */
struct sensed {
    int32_t position_nm[3], rotation_q30[4];
    uint32_t speed_um_s, spin_urad_s;
};

struct device {
    struct limits limits;
    enum mode mode;
    bool session, scolded, latched, has_accepted;
    enum cause cause;
    uint32_t t_us, seq, period_us, until_report_us, since_host, since_command, accepted, hold_us, fade;
    int32_t force_un[3], torque_unm[3];
    uint8_t flags;
    /* bytes on their way out, whole frames */
    uint8_t out[OUT_BYTES];
    size_t out_n;
    /* the frame that is coming in */
    uint8_t frame[FRAME_MAX];
    size_t frame_n;
    /* books */
    uint32_t messages, rejected, commands, reports, faults, dropped;
    bool trace;
};

static void send_frame(struct device *d, struct writer *w)
{
    uint8_t frame[FRAME_MAX];
    size_t n = finish_frame(w, frame);
    if (d->out_n + n > sizeof d->out) {
        d->dropped++;
        return;
    }
    memcpy(d->out + d->out_n, frame, n);
    d->out_n += n;
}

static void send_hello(struct device *d)
{
    const struct limits *l = &d->limits;
    struct writer w = { .n = 0 };
    put_unsigned(&w, DEVICE_HELLO);
    put_unsigned(&w, l->version);
    put_unsigned(&w, SCHEMA);
    for (int i = 0; i < TEXT; i++)
        put_byte(&w, (uint8_t)l->name[i]);
    for (int i = 0; i < TEXT; i++)
        put_byte(&w, (uint8_t)l->serial[i]);
    put_unsigned(&w, l->max_force_un);
    put_unsigned(&w, l->max_torque_unm);
    put_unsigned(&w, l->watchdog_ticks);
    send_frame(d, &w);
}

static void send_fault(struct device *d, enum cause cause, int32_t detail)
{
    struct writer w = { .n = 0 };
    put_unsigned(&w, DEVICE_FAULT);
    put_unsigned(&w, cause);
    put_unsigned(&w, d->seq - 1);
    put_signed(&w, detail);
    send_frame(d, &w);
    d->faults++;
    printf("fault %d detail %ld\n", (int)cause, (long)detail);
}

static void send_report(struct device *d, const struct sensed *s)
{
    uint8_t latched = 0;
    if (d->latched)
        latched = d->cause == OVER_SPEED ? TOO_FAST : d->cause == WATCHDOG ? STARVED : 0;
    struct writer w = { .n = 0 };
    put_unsigned(&w, POSE_REPORT);
    put_unsigned(&w, d->seq++);
    put_unsigned(&w, d->t_us);
    for (int i = 0; i < 3; i++)
        put_signed(&w, s->position_nm[i]);
    for (int i = 0; i < 4; i++)
        put_signed(&w, s->rotation_q30[i]);
    put_byte(&w, 0);
    put_unsigned(&w, d->mode);
    put_byte(&w, d->flags | latched);
    put_unsigned(&w, d->has_accepted ? d->accepted : 0);
    send_frame(d, &w);
    d->flags = 0;
    d->reports++;
}

static void zero_wrench(struct device *d)
{
    memset(d->force_un, 0, sizeof d->force_un);
    memset(d->torque_unm, 0, sizeof d->torque_unm);
    d->hold_us = d->fade = 0;
}

static void enter(struct device *d, enum mode mode)
{
    zero_wrench(d);
    d->mode = mode;
}

/* Rules 7, 10, 11: the fault is told once and stays until a reset. */
static void latch(struct device *d, enum cause cause, int32_t detail)
{
    enter(d, BRAKE);
    d->latched = true;
    d->cause = cause;
    send_fault(d, cause, detail);
}

/* Rule 4. */
static void scold(struct device *d)
{
    if (!d->scolded)
        send_fault(d, OUT_OF_TURN, (int32_t)d->mode);
    d->scolded = true;
}

/* Rule 2. */
static void take_hello(struct device *d, const struct order *o)
{
    send_hello(d);
    d->session = o->version == d->limits.version && o->schema == SCHEMA;
    d->has_accepted = d->scolded = false;
    d->until_report_us = 0;
    d->period_us = o->period_us == 0 ? PERIOD_US : o->period_us;
    if (d->period_us < TICK_US)
        d->period_us = TICK_US;
    if (d->period_us > LONGEST_PERIOD_US)
        d->period_us = LONGEST_PERIOD_US;
    enter(d, d->mode == BRAKE ? BRAKE : d->session ? IDLE : RESET);
    if (!d->session)
        send_fault(d, VERSION_MISMATCH, (int32_t)d->limits.version);
}

/* Rules 3 and 4. */
static void take_mode(struct device *d, enum mode asked)
{
    if (asked == RESET) {
        enter(d, RESET);
        d->latched = false;
        d->flags = 0;
    } else if (d->mode == BRAKE) {
        /* left through Reset only */
    } else if (asked == BRAKE) {
        enter(d, BRAKE);
    } else if (!d->session || (d->mode == RESET && asked == FORCE)) {
        scold(d);
    } else if (asked == IDLE) {
        enter(d, IDLE);
    } else if (d->mode == IDLE) {
        enter(d, FORCE);
        d->since_command = 0;
    }
}

static bool is_number(const int32_t v[3])
{
    return v[0] != INT32_MIN && v[1] != INT32_MIN && v[2] != INT32_MIN;
}

/* Largest whole number whose square is not above n. */
static uint64_t root(uint64_t n)
{
    uint64_t found = 0;
    for (uint64_t bit = (uint64_t)1 << 31; bit > 0; bit >>= 1)
        if ((found + bit) * (found + bit) <= n)
            found += bit;
    return found;
}

/* Rule 8: scales v down to the limit without turning it; true when that was needed. */
static bool shorten(int32_t v[3], uint32_t limit)
{
    uint64_t squared = 0;
    for (int i = 0; i < 3; i++)
        squared += (uint64_t)((int64_t)v[i] * v[i]);
    if (squared <= (uint64_t)limit * limit)
        return false;
    int64_t length = (int64_t)root(squared) + 1;
    for (int i = 0; i < 3; i++)
        v[i] = (int32_t)((int64_t)v[i] * limit / length);
    return true;
}

/* Rules 4, 6, 7, 8, 9. */
static void take_wrench(struct device *d, const struct order *o)
{
    if (d->mode == RESET && !d->session)
        scold(d);
    if (d->mode == RESET || d->mode == BRAKE)
        return;
    uint32_t ahead = o->seq - d->accepted;
    if (d->has_accepted && (ahead == 0 || ahead > INT32_MAX))
        return;
    if (!is_number(o->force_un) || !is_number(o->torque_unm)) {
        latch(d, NON_FINITE, (int32_t)o->seq);
        return;
    }
    d->has_accepted = true;
    d->accepted = o->seq;
    d->commands++;
    if (d->mode != FORCE)
        return;
    d->since_command = 0;
    memcpy(d->force_un, o->force_un, sizeof d->force_un);
    memcpy(d->torque_unm, o->torque_unm, sizeof d->torque_unm);
    if (shorten(d->force_un, d->limits.max_force_un))
        d->flags |= FORCE_CUT;
    if (shorten(d->torque_unm, d->limits.max_torque_unm))
        d->flags |= d->limits.max_torque_unm ? TORQUE_CUT : NO_TORQUE;
    d->hold_us = o->hold_us;
    d->fade = FADE_TICKS;
}

static void take_order(struct device *d, const struct order *o)
{
    d->messages++;
    d->since_host = 0;
    switch (o->kind) {
    case HOST_HELLO: take_hello(d, o); break;
    case SET_MODE: take_mode(d, (enum mode)o->mode); break;
    default: take_wrench(d, o); break;
    }
}

/* Section 4: gathers bytes up to a zero. One byte more than a frame may have marks one that is too long. */
static void take_byte(struct device *d, uint8_t byte)
{
    if (byte != 0) {
        if (d->frame_n < sizeof d->frame)
            d->frame[d->frame_n++] = byte;
        return;
    }
    struct order order;
    size_t n = d->frame_n;
    d->frame_n = 0;
    if (n == 0)
        return;
    if (n < sizeof d->frame && read_order(d->frame, n, &order))
        take_order(d, &order);
    else
        d->rejected++;
}

/* Rules 10 to 12. */
static void watch(struct device *d, const struct sensed *s)
{
    if (d->since_host <= SESSION_TICKS)
        d->since_host++;
    if (d->mode != FORCE) {
        if (d->since_host > SESSION_TICKS) {
            d->session = false;
            if (d->mode == IDLE)
                take_mode(d, RESET);
        }
    } else if (s->speed_um_s > d->limits.over_speed_um_s) {
        latch(d, OVER_SPEED, (int32_t)s->speed_um_s);
    } else if (s->spin_urad_s > d->limits.over_spin_urad_s) {
        latch(d, OVER_SPEED, -(int32_t)s->spin_urad_s);
    } else if (++d->since_command >= d->limits.watchdog_ticks) {
        latch(d, WATCHDOG, (int32_t)d->since_command);
    }
}

/* What the motors are given until the next tick: rule 9. Here nobody feels it; with --trace it is printed when it changes. */
static void render(struct device *d)
{
    static int32_t last[6];
    int32_t now[6] = { 0 };
    for (int i = 0; i < 3 && d->mode == FORCE; i++) {
        now[i] = (int32_t)((int64_t)d->force_un[i] * d->fade / FADE_TICKS);
        now[3 + i] = (int32_t)((int64_t)d->torque_unm[i] * d->fade / FADE_TICKS);
    }
    if (d->hold_us > 0)
        d->hold_us -= d->hold_us < TICK_US ? d->hold_us : TICK_US;
    else if (d->fade > 0)
        d->fade--;
    if (d->trace && memcmp(last, now, sizeof now) != 0)
        printf("render %ld %ld %ld %ld %ld %ld\n", (long)now[0], (long)now[1], (long)now[2], (long)now[3], (long)now[4], (long)now[5]);
    memcpy(last, now, sizeof now);
}

/* Lets TICK_US pass. */
static void tick(struct device *d, const struct sensed *s)
{
    d->t_us += TICK_US;
    watch(d, s);
    render(d);
    if (!d->session)
        return;
    d->until_report_us -= d->until_report_us < TICK_US ? d->until_report_us : TICK_US;
    if (d->until_report_us == 0) {
        d->until_report_us = d->period_us;
        send_report(d, s);
    }
}

/* ---- 4. A motion in place of sensors ---- */

/* Where the handle is: along x and z, and turned about z by four times the angle whose tangent is `turn`. */
struct place {
    double seconds; /* to get there */
    double x, z;    /* [m] */
    double turn;
};

/* Down to the object 5 mm below, 0.4 mm into it, half a radian round, 5 mm along, up, home. */
static const struct place PATH[] = {
    { 0.5, 0, -5.0e-3, 0 },    { 0.5, 0, -5.4e-3, 0 },        { 0.2, 0, -5.4e-3, 0 },   { 0.8, 0, -5.4e-3, 0.125 },
    { 0.1, 0, -5.4e-3, 0.125 }, { 0.8, 5e-3, -5.4e-3, 0.125 }, { 0.5, 5e-3, 0, 0.125 }, { 0.4, 0, 0, 0 },
};

static struct place place_at(double t)
{
    struct place from = { 0, 0, 0, 0 };
    for (size_t i = 0; i < sizeof PATH / sizeof *PATH; i++) {
        const struct place *to = &PATH[i];
        if (t < to->seconds) {
            double s = t / to->seconds, share = s * s * s * (10 + s * (6 * s - 15));
            from.x += share * (to->x - from.x);
            from.z += share * (to->z - from.z);
            from.turn += share * (to->turn - from.turn);
            return from;
        }
        t -= to->seconds;
        from = *to;
    }
    return from;
}

static double path_seconds(void)
{
    double sum = 0;
    for (size_t i = 0; i < sizeof PATH / sizeof *PATH; i++)
        sum += PATH[i].seconds;
    return sum;
}

static double size_of(double x)
{
    return x < 0 ? -x : x;
}

static int32_t rounded(double x)
{
    return (int32_t)(x < 0 ? x - 0.5 : x + 0.5);
}

/* What encoders would say at time t of the path; speeds from where it was one tick before. The parts of a quaternion that turns by four
 * times atan(u) are (1 - u^2) / (1 + u^2) and 2 u / (1 + u^2): no sine is needed. */
static void sense(double t, struct sensed *s)
{
    const double tick_s = TICK_US * 1e-6;
    struct place now = place_at(t), before = place_at(t < tick_s ? 0 : t - tick_s);
    double u = now.turn, whole = 1 + u * u, q30 = (double)(1 << 30);
    memset(s, 0, sizeof *s);
    s->position_nm[0] = rounded(now.x * 1e9);
    s->position_nm[2] = rounded(now.z * 1e9);
    s->rotation_q30[0] = rounded((1 - u * u) / whole * q30);
    s->rotation_q30[3] = rounded(2 * u / whole * q30);
    s->speed_um_s = (uint32_t)((size_of(now.x - before.x) + size_of(now.z - before.z)) / tick_s * 1e6);
    s->spin_urad_s = (uint32_t)(4 * size_of(now.turn - before.turn) / whole / tick_s * 1e6);
}

/* ---- 5. A port, a clock, a program ---- */

enum {
    TURN_US = 1000,          /* the loop's own period */
    LATEST_NS = 3000000,     /* later than this, time stands still: hardware does not make up for a busy computer */
    GARBAGE_BYTES = 40,
};

struct port {
    int fd;
    char path[256];
    bool is_pty;
    int held; /* far side of a pseudo-terminal, held open while no host does, or -1 */
};

static volatile sig_atomic_t stopped;

static void on_signal(int number)
{
    (void)number;
    stopped = 1;
}

static void die(const char *what)
{
    fprintf(stderr, "device: %s: %s\n", what, strerror(errno));
    exit(EXIT_FAILURE);
}

static void make_raw(int fd)
{
    struct termios t;
    if (tcgetattr(fd, &t) != 0)
        die("no terminal");
    t.c_iflag = t.c_oflag = t.c_lflag = 0;
    t.c_cflag = CS8 | CREAD | CLOCAL;
    t.c_cc[VMIN] = 1;
    t.c_cc[VTIME] = 0;
    if (tcsetattr(fd, TCSANOW, &t) != 0)
        die("cannot set the port");
}

/* While nobody holds the far side reading fails, and settings are lost. */
static void hold(struct port *p)
{
    if ((p->held = open(p->path, O_RDWR | O_NOCTTY)) < 0)
        die(p->path);
    make_raw(p->held);
}

static void open_port(struct port *p, const char *path)
{
    p->held = -1;
    p->is_pty = path == NULL;
    if (p->is_pty) {
        p->fd = posix_openpt(O_RDWR | O_NOCTTY);
        if (p->fd < 0 || grantpt(p->fd) != 0 || unlockpt(p->fd) != 0)
            die("cannot make a pseudo-terminal");
        path = ptsname(p->fd);
    } else if ((p->fd = open(path, O_RDWR | O_NOCTTY)) < 0) {
        die(path);
    }
    snprintf(p->path, sizeof p->path, "%s", path);
    if (p->is_pty)
        hold(p);
    else
        make_raw(p->fd);
    if (fcntl(p->fd, F_SETFL, O_NONBLOCK) != 0)
        die(p->path);
}

static void receive(struct port *p, struct device *d)
{
    uint8_t bytes[4096];
    ssize_t n = read(p->fd, bytes, sizeof bytes);
    for (ssize_t i = 0; i < n; i++)
        take_byte(d, bytes[i]);
    if (n > 0 && p->held >= 0) {
        /* a host is there: let go, so that its leaving shows */
        close(p->held);
        p->held = -1;
    } else if (n < 0 && errno == EIO && p->is_pty && p->held < 0) {
        hold(p);
        d->frame_n = d->out_n = 0;
    }
}

static void transmit(struct port *p, struct device *d)
{
    ssize_t n = d->out_n > 0 ? write(p->fd, d->out, d->out_n) : 0;
    if (n > 0) {
        memmove(d->out, d->out + n, d->out_n - (size_t)n);
        d->out_n -= (size_t)n;
    }
}

/* Noise on the line, by a linear congruential generator; never a zero, so that it spoils the frame that follows. */
static void inject_garbage(struct device *d)
{
    static uint32_t random = 1;
    for (int i = 0; i < GARBAGE_BYTES && d->out_n < sizeof d->out; i++) {
        random = random * 1664525u + 1013904223u;
        d->out[d->out_n++] = (uint8_t)(random >> 24) | 1;
    }
}

static void wait_turn(struct timespec *next)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    next->tv_nsec += TURN_US * 1000;
    next->tv_sec += next->tv_nsec / 1000000000;
    next->tv_nsec %= 1000000000;
    int64_t late_ns = (int64_t)(now.tv_sec - next->tv_sec) * 1000000000 + (now.tv_nsec - next->tv_nsec);
    if (late_ns > LATEST_NS)
        *next = now;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, next, NULL) == EINTR && !stopped) {}
}

struct options {
    const char *path;
    uint32_t seconds, garbage_every;
};

/* NAME VALUE pairs, --trace, and the path of a port. */
static void read_options(int argc, char **argv, struct options *o, struct device *d)
{
    struct { const char *name; uint32_t *value; } table[] = {
        { "--seconds", &o->seconds },           { "--garbage-every", &o->garbage_every },
        { "--version", &d->limits.version },    { "--watchdog-ticks", &d->limits.watchdog_ticks },
        { "--max-torque-unm", &d->limits.max_torque_unm }, { "--over-speed-um-s", &d->limits.over_speed_um_s },
    };
    for (int i = 1; i < argc; i++) {
        size_t row = 0, rows = sizeof table / sizeof *table;
        while (row < rows && strcmp(argv[i], table[row].name) != 0)
            row++;
        if (row < rows && i + 1 < argc) {
            *table[row].value = (uint32_t)strtoul(argv[++i], NULL, 10);
        } else if (strcmp(argv[i], "--trace") == 0) {
            d->trace = true;
        } else if (argv[i][0] != '-' && o->path == NULL) {
            o->path = argv[i];
        } else {
            fprintf(stderr, "usage: device [PORT] [--trace]");
            for (row = 0; row < rows; row++)
                fprintf(stderr, " [%s N]", table[row].name);
            fprintf(stderr, "\n");
            exit(2);
        }
    }
}

/* One turn: what came, eight ticks, what is to go. The path begins when forces are first armed and then goes round and round. */
static void turn(struct port *p, struct device *d, double *t)
{
    struct sensed s;
    receive(p, d);
    for (int i = 0; i < TURN_US / TICK_US; i++) {
        sense(*t, &s);
        tick(d, &s);
        if (*t > 0 || d->mode == FORCE)
            *t += TICK_US * 1e-6;
        if (*t >= path_seconds())
            *t -= path_seconds();
    }
    transmit(p, d);
}

int main(int argc, char **argv)
{
    static struct device d = { .limits = { "c-example", "C-1", VERSION, 8500000, 188000, 240, 1000000, 20000000 } };
    struct options options = { NULL, 0, 0 };
    struct port port;
    struct timespec next;
    double t = 0;
    read_options(argc, argv, &options, &d);
    setvbuf(stdout, NULL, _IOLBF, 0);
    open_port(&port, options.path);
    struct sigaction stop = { .sa_handler = on_signal };
    sigaction(SIGTERM, &stop, NULL);
    sigaction(SIGINT, &stop, NULL);
    printf("serving pty %s\n", port.path);
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (uint32_t turns = 1; !stopped && (options.seconds == 0 || turns <= options.seconds * 1000); turns++) {
        wait_turn(&next);
        if (options.garbage_every > 0 && turns % options.garbage_every == 0)
            inject_garbage(&d);
        turn(&port, &d, &t);
    }
    printf("messages %lu rejected %lu commands %lu reports %lu faults %lu dropped %lu\n", (unsigned long)d.messages,
           (unsigned long)d.rejected, (unsigned long)d.commands, (unsigned long)d.reports, (unsigned long)d.faults,
           (unsigned long)d.dropped);
    return 0;
}
