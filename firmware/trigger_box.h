/* The trigger box without its microcontroller: lines in, answers out, and what it may fire.
 *
 * The protocol is docs/reference/wire-protocols.md, version 2. A board's own file (atmega328p.c)
 * gives the functions whose names begin with board_; all of them are called with interrupts on.
 */
#ifndef TRIGGER_BOX_H
#define TRIGGER_BOX_H

#include <stdbool.h>
#include <stdint.h>

#define LONGEST_LINE 40 /* of the host, checksum included, without its ending */

/* --- what the protocol offers to the board --- */

/* Answer one line (without its ending) by calls of board_send. */
void trigger_box_line(char *line, uint8_t length);

/* Answer a line that was too long for LONGEST_LINE. */
void trigger_box_line_too_long(void);

/* --- what the board gives --- */

/* A pair of pulses; times in microseconds. */
typedef struct {
    int32_t delay_us; /* b after a; negative: a after b */
    uint32_t width_us;
} pulses_t;

typedef enum { WATCH_NONE, WATCH_KEPT, WATCH_LATE } watch_state_t;

/* Queue one character for the host. */
void board_send(char character);

/* Whether the outputs have power, as sensed at the outputs' supply. */
bool board_is_powered(void);

/* Be armed from now on for 5 s, or until the power goes, the watch is late, or board_disarm. */
void board_arm(void);
bool board_is_armed(void);

/* Disarm; both outputs low at once. */
void board_disarm(void);

/* Whether a pulse is high or still to come. */
bool board_is_pulsing(void);

/* If armed, powered and the watch not late: disarm, give both pulses, wait for the first to rise,
 * and set `first_us` to the box's clock at that edge. False: something took the power or the
 * arming before the edge, and nothing has risen. */
bool board_fire(const pulses_t *pulses, uint64_t *first_us);

/* Begin a watch (0 ms ends it); begin its time anew; say how it is. */
void board_watch(uint16_t period_ms);
void board_beat(void);
watch_state_t board_watch_state(void);
uint16_t board_watch_period_ms(void);

#endif
