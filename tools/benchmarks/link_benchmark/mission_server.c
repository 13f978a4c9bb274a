/* A vehicle that does nothing but hold a mission, so quick that what is measured against it is the client.
 *
 *     mission_server px4|ardupilot        prints its UDP port on 127.0.0.1, and serves until its stdin is closed
 *
 * MAVLink 2 mission service with the habits of PX4 (asks with MISSION_REQUEST_INT, again every 0.25 s; tells its
 * mission state) or of ArduPilot (asks with MISSION_REQUEST, again every second; gives its own home back as item 0).
 * No signing, one list, one ground station at a time: whoever spoke last is answered.
 */
#include <arpa/inet.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    HEARTBEAT = 0, SYS_STATUS = 1, PING = 4, MISSION_REQUEST = 40, MISSION_CURRENT = 42, MISSION_REQUEST_LIST = 43,
    MISSION_COUNT = 44, MISSION_CLEAR_ALL = 45, MISSION_ACK = 47, MISSION_REQUEST_INT = 51, MISSION_ITEM_INT = 73,
    COMMAND_LONG = 76, COMMAND_ACK = 77, AUTOPILOT_VERSION = 148
};
enum { REQUEST_MESSAGE = 512, ACCEPTED = 0, UNSUPPORTED = 3, INVALID_SEQUENCE = 13, NOT_STARTED = 2, STANDBY = 3 };
enum { MISSION_INT = 4, MAVLINK2 = 0x2000, ITEM_BYTES = 38, MOST_ITEMS = 65535 };
enum { MAGIC = 0xFD, HEADER = 10, SYSTEM = 1, COMPONENT = 1 };

static uint8_t items[MOST_ITEMS][ITEM_BYTES];
static int held, expected, asked, is_px4, out;
static double last_progress, last_question;
static struct sockaddr_in station;
static uint8_t station_system, station_component, sequence;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int crc_extra(int number) {
    switch (number) {
    case HEARTBEAT: return 50;
    case SYS_STATUS: return 124;
    case PING: return 237;
    case MISSION_REQUEST: return 230;
    case MISSION_CURRENT: return 28;
    case MISSION_REQUEST_LIST: return 132;
    case MISSION_COUNT: return 221;
    case MISSION_CLEAR_ALL: return 232;
    case MISSION_ACK: return 153;
    case MISSION_REQUEST_INT: return 196;
    case MISSION_ITEM_INT: return 38;
    case COMMAND_LONG: return 152;
    case COMMAND_ACK: return 143;
    case AUTOPILOT_VERSION: return 178;
    default: return -1;
    }
}

/* CRC-16/MCRF4XX, without a table. */
static uint16_t crc(const uint8_t *data, int length, uint8_t extra) {
    uint16_t sum = 0xFFFF;
    for (int n = 0; n <= length; n++) {
        uint8_t byte = (n < length ? data[n] : extra) ^ (uint8_t)sum;
        byte ^= (uint8_t)(byte << 4);
        sum = (sum >> 8) ^ (uint16_t)(byte << 8) ^ (uint16_t)(byte << 3) ^ (byte >> 4);
    }
    return sum;
}

static void say(int number, const void *payload, int length) {
    uint8_t frame[HEADER + 255 + 2] = {MAGIC};
    memcpy(frame + HEADER, payload, length);
    while (length > 1 && !frame[HEADER + length - 1]) length--;
    frame[1] = length;
    frame[4] = sequence++;
    frame[5] = SYSTEM;
    frame[6] = COMPONENT;
    frame[7] = number;
    uint16_t sum = crc(frame + 1, HEADER - 1 + length, crc_extra(number));
    memcpy(frame + HEADER + length, &sum, 2);
    if (station.sin_port)
        sendto(out, frame, HEADER + length + 2, 0, (struct sockaddr *)&station, sizeof station);
}

static void put16(uint8_t *at, int value) {
    at[0] = value;
    at[1] = value >> 8;
}

static int get16(const uint8_t *at) { return at[0] | at[1] << 8; }

static void ask(void) {
    uint8_t payload[5] = {0, 0, station_system, station_component};
    put16(payload, asked);
    say(is_px4 ? MISSION_REQUEST_INT : MISSION_REQUEST, payload, sizeof payload);
    last_question = now();
}

static void acknowledge(int result) {
    uint8_t payload[4] = {station_system, station_component, result};
    say(MISSION_ACK, payload, sizeof payload);
}

static void tell_count(void) {
    uint8_t payload[5] = {0, 0, station_system, station_component};
    put16(payload, held);
    say(MISSION_COUNT, payload, sizeof payload);
}

static void tell_current(void) {
    uint8_t payload[6] = {0, 0, 0, 0, NOT_STARTED, 2};
    put16(payload + 2, held);
    say(MISSION_CURRENT, payload, sizeof payload);
}

static void tell_presence(void) {
    uint8_t beat[9] = {0, 0, 0, 0, 2, is_px4 ? 12 : 3, 1, STANDBY, 3};
    say(HEARTBEAT, beat, sizeof beat);
    if (is_px4 && held && asked >= expected) tell_current();
}

static void take(const uint8_t *item) {
    int seq = get16(item + 28);
    if (asked >= expected || seq != asked) {
        if (!is_px4) acknowledge(INVALID_SEQUENCE);
        return;
    }
    memcpy(items[seq], item, ITEM_BYTES);
    items[seq][32] = station_system;
    items[seq][33] = station_component;
    last_progress = now();
    if (++asked < expected) {
        ask();
        return;
    }
    held = expected;
    acknowledge(ACCEPTED);
    if (is_px4) tell_current();
}

static void obey(const uint8_t *payload) {
    uint8_t answer[10] = {0};
    float wanted;
    memcpy(&wanted, payload, 4);
    int command = get16(payload + 28), knows = command == REQUEST_MESSAGE && wanted == AUTOPILOT_VERSION;
    put16(answer, command);
    answer[2] = knows ? ACCEPTED : UNSUPPORTED;
    answer[8] = station_system;
    answer[9] = station_component;
    say(COMMAND_ACK, answer, sizeof answer);
    if (knows) {
        uint8_t version[60] = {0};
        put16(version, MISSION_INT | MAVLINK2);
        say(AUTOPILOT_VERSION, version, sizeof version);
    }
}

static void hear(const uint8_t *frame, int size) {
    if (size < HEADER + 2 || frame[0] != MAGIC || frame[2] || size < HEADER + frame[1] + 2) return;
    int number = frame[7] | frame[8] << 8 | frame[9] << 16, length = frame[1], extra = crc_extra(number);
    if (extra < 0 || crc(frame + 1, HEADER - 1 + length, extra) != get16(frame + HEADER + length)) return;
    uint8_t payload[255 + ITEM_BYTES] = {0};
    memcpy(payload, frame + HEADER, length);
    int seq = get16(payload);
    station_system = frame[5];
    station_component = frame[6];
    switch (number) {
    case MISSION_COUNT:
        expected = seq;
        asked = 0;
        last_progress = now();
        if (expected) {
            ask();
        } else {
            held = 0;
            acknowledge(ACCEPTED);
        }
        break;
    case MISSION_ITEM_INT: take(payload); break;
    case MISSION_REQUEST_LIST: tell_count(); break;
    case MISSION_REQUEST:
    case MISSION_REQUEST_INT:
        if (seq < held) say(MISSION_ITEM_INT, items[seq], ITEM_BYTES);
        break;
    case MISSION_CLEAR_ALL:
        held = expected = asked = 0;
        acknowledge(ACCEPTED);
        break;
    case COMMAND_LONG: obey(payload); break;
    case PING: {
        uint8_t answer[14];
        memcpy(answer, payload, 12);
        answer[12] = station_system;
        answer[13] = station_component;
        say(PING, answer, sizeof answer);
    }
    }
}

int main(int count, char **arguments) {
    is_px4 = count > 1 && !strcmp(arguments[1], "px4");
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof here;
    out = socket(AF_INET, SOCK_DGRAM, 0);
    if (bind(out, (struct sockaddr *)&here, size) || getsockname(out, (struct sockaddr *)&here, &size)) return 1;
    printf("%d\n", ntohs(here.sin_port));
    fflush(stdout);
    struct pollfd waited[2] = {{.fd = out, .events = POLLIN}, {.fd = STDIN_FILENO, .events = POLLIN}};
    double next_beat = 0, again = is_px4 ? 0.25 : 1.0, patience = is_px4 ? 5.0 : 8.0;
    for (;;) {
        poll(waited, 2, 50);
        if (waited[1].revents) return 0;
        if (waited[0].revents) {
            uint8_t data[2048];
            size = sizeof station;
            hear(data, (int)recvfrom(out, data, sizeof data, 0, (struct sockaddr *)&station, &size));
        }
        double moment = now();
        if (asked < expected && moment - last_progress > patience) expected = 0;
        if (asked < expected && moment - last_question > again) ask();
        if (moment >= next_beat) {
            next_beat = moment + 1.0;
            tell_presence();
        }
    }
}
