/* Takes lines apart, refuses in the protocol's order, and remembers which numbers have fired. */
#include "trigger_box.h"

#include <string.h>

#define LONGEST_DELAY_US 100000UL
#define SHORTEST_PULSE_US 100UL
#define LONGEST_PULSE_US 100000UL
#define SHORTEST_WATCH_MS 100U
#define LONGEST_WATCH_MS 10000U

static struct {
    uint32_t armed_sequence;
    pulses_t pulses;
    uint32_t last_sequence; /* 0: none has fired since power-on */
    uint32_t fires;
} box;

/* --- answers: each character is part of the checksum until it is closed --- */

static uint8_t checksum;
static const char hexadecimal[] = "0123456789ABCDEF";

static void say(const char *text)
{
    for (; *text; text++) {
        checksum ^= (uint8_t)*text;
        board_send(*text);
    }
}

static void say_number(uint64_t number)
{
    char digits[21];
    uint8_t at = sizeof digits - 1;
    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + number % 10);
        number /= 10;
    } while (number);
    say(&digits[at]);
}

static void say_with(const char *text, uint32_t number)
{
    say(text);
    say_number(number);
}

static void close_answer(void)
{
    uint8_t sum = checksum;
    board_send('*');
    board_send(hexadecimal[sum >> 4]);
    board_send(hexadecimal[sum & 15]);
    board_send('\n');
    checksum = 0;
}

/* --- questions --- */

/* Read `-` if allowed and 1 to `most` digits; leave `*text` behind them. False: none, or more. */
static bool read_number(const char **text, uint8_t most, bool *negative, uint64_t *number)
{
    const char *at = *text;
    uint8_t digits = 0;
    *number = 0;
    if (negative) {
        *negative = *at == '-';
        at += *negative;
    }
    for (; *at >= '0' && *at <= '9'; at++, digits++)
        *number = 10 * *number + (uint8_t)(*at - '0');
    *text = at;
    return digits >= 1 && digits <= most;
}

static bool skip(const char **text, const char *word)
{
    size_t length = strlen(word);
    if (strncmp(*text, word, length) != 0)
        return false;
    *text += length;
    return true;
}

/* --- commands; each gives one answer without its checksum --- */

static bool refused_as_unable(void)
{
    if (board_watch_state() == WATCH_LATE)
        say_with("ERR LATE ", board_watch_period_ms());
    else if (!board_is_powered())
        say("ERR CUT no power");
    else
        return false;
    return true;
}

static bool refused_as_out_of_range(uint64_t sequence, uint32_t delay_us, uint32_t width_us)
{
    if (sequence < 1 || sequence > UINT32_MAX)
        say("ERR RANGE sequence 1 to 4294967295");
    else if (delay_us > LONGEST_DELAY_US)
        say("ERR RANGE delay within 100000 us");
    else if (width_us < SHORTEST_PULSE_US || width_us > LONGEST_PULSE_US)
        say("ERR RANGE width 100 to 100000 us");
    else
        return false;
    return true;
}

static bool arm(const char *text)
{
    uint64_t sequence, delay_us, width_us;
    bool a_follows;
    if (!(read_number(&text, 10, NULL, &sequence) && skip(&text, " ")
          && read_number(&text, 9, &a_follows, &delay_us) && skip(&text, " ")
          && read_number(&text, 9, NULL, &width_us) && *text == '\0'))
        return false;
    if (refused_as_out_of_range(sequence, (uint32_t)delay_us, (uint32_t)width_us))
        return true;
    if (sequence == box.last_sequence)
        say_with("ERR DUPLICATE ", (uint32_t)sequence);
    else if (sequence < box.last_sequence)
        say_with("ERR SEQUENCE above ", box.last_sequence);
    else if (refused_as_unable())
        return true;
    else if (board_is_pulsing())
        say("ERR BUSY pulses under way");
    else {
        box.armed_sequence = (uint32_t)sequence;
        box.pulses.delay_us = a_follows ? -(int32_t)delay_us : (int32_t)delay_us;
        box.pulses.width_us = (uint32_t)width_us;
        board_arm();
        say_with("ARMED ", box.armed_sequence);
    }
    return true;
}

static bool fire(const char *text)
{
    uint64_t sequence, first_us;
    if (!(read_number(&text, 10, NULL, &sequence) && *text == '\0'))
        return false;
    if (box.last_sequence && sequence == box.last_sequence) {
        say_with("ERR DUPLICATE ", (uint32_t)sequence);
    } else if (refused_as_unable()) {
        return true;
    } else if (!board_is_armed()) {
        say("ERR NOTARMED no number");
    } else if (sequence != box.armed_sequence) {
        say_with("ERR SEQUENCE ", box.armed_sequence);
        say(" is armed");
    } else {
        /* Counted before the edge: a number whose edge is in doubt never fires again. */
        box.last_sequence = box.armed_sequence;
        box.fires++;
        if (board_fire(&box.pulses, &first_us)) {
            say_with("FIRED ", box.last_sequence);
            say(" ");
            say_number(first_us);
        } else if (!refused_as_unable()) {
            say("ERR NOTARMED no number");
        }
    }
    return true;
}

static bool watch(const char *text)
{
    uint64_t period_ms;
    if (!(read_number(&text, 5, NULL, &period_ms) && *text == '\0'))
        return false;
    if (period_ms && (period_ms < SHORTEST_WATCH_MS || period_ms > LONGEST_WATCH_MS)) {
        say("ERR RANGE period 0 or 100 to 10000 ms");
    } else {
        board_watch((uint16_t)period_ms);
        say_with("WATCHING ", (uint32_t)period_ms);
    }
    return true;
}

static void beat(void)
{
    switch (board_watch_state()) {
    case WATCH_NONE:
        say("ERR NOWATCH none is set");
        break;
    case WATCH_LATE:
        say_with("ERR LATE ", board_watch_period_ms());
        break;
    case WATCH_KEPT:
        board_beat();
        say("BEAT");
        break;
    }
}

static void status(void)
{
    say(board_is_armed() ? "STAT ARMED " : "STAT SAFE ");
    say_number(box.last_sequence);
    say_with(" ", box.fires);
    say(board_is_powered() ? " 1" : " 0");
}

static bool obeyed(const char *command)
{
    if (skip(&command, "ARM "))
        return arm(command);
    if (skip(&command, "FIRE "))
        return fire(command);
    if (skip(&command, "WATCH "))
        return watch(command);
    if (strcmp(command, "BEAT") == 0) {
        beat();
    } else if (strcmp(command, "SAFE") == 0) {
        board_disarm();
        say("SAFE");
    } else if (strcmp(command, "ID?") == 0) {
        say("RIGTRIG 2 2");
    } else if (strcmp(command, "STAT?") == 0) {
        status();
    } else {
        return false;
    }
    return true;
}

/* --- lines --- */

/* Return 0 to 15, or 16 for what is no upper-case hexadecimal digit. */
static uint8_t nibble(char digit)
{
    if (digit >= '0' && digit <= '9')
        return (uint8_t)(digit - '0');
    if (digit >= 'A' && digit <= 'F')
        return (uint8_t)(digit - 'A' + 10);
    return 16;
}

static bool is_closed(const char *line, uint8_t length)
{
    if (length < 3 || line[length - 3] != '*')
        return false;
    return nibble(line[length - 2]) < 16 && nibble(line[length - 1]) < 16
           && !memchr(line, '*', length - 3U) && !memchr(line, '\0', length);
}

void trigger_box_line(char *line, uint8_t length)
{
    uint8_t sum = 0;
    if (!is_closed(line, length)) {
        say("ERR SYNTAX no checksum");
    } else {
        for (uint8_t at = 0; at < length - 3; at++)
            sum ^= (uint8_t)line[at];
        if (sum != (nibble(line[length - 2]) << 4 | nibble(line[length - 1]))) {
            const char wanted[] = {hexadecimal[sum >> 4], hexadecimal[sum & 15], '\0'};
            say("ERR CHECKSUM ");
            say(wanted);
        } else {
            line[length - 3] = '\0';
            if (!obeyed(line))
                say("ERR SYNTAX unknown command");
        }
    }
    close_answer();
}

void trigger_box_line_too_long(void)
{
    say("ERR SYNTAX line too long");
    close_answer();
}
