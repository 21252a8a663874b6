/* The board of the trigger box: ATmega328P at 16 MHz, as on an Arduino Nano.
 *
 * PB1 (D9)  output a        PD2 (D2)  power of the outputs, sensed: high is on
 * PB2 (D10) output b        PD4 (D4)  contact of the watch: high while the watch is kept
 *
 * Each edge of each pulse is made by timer 1's compare unit, in the clock cycle that was set before:
 * neither a loop nor an interrupt's delay reaches a pin. Interrupts only set up the next edge, at
 * least 100 us ahead. Once a pulse has fallen its unit is disconnected: a unit left connected
 * makes the edge again each time that the 16-bit timer comes round (262 ms).
 */
#include "trigger_box.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>
#include <util/atomic.h>

#define TICK_US 4U        /* timer 1 at 16 MHz / 64 */
#define LEAD_TICKS 8U     /* from the decision to fire to the first edge: 32 us */
#define ARMED_FOR_MS 5000U
#define GRACE_MS 8U       /* for a heartbeat that has come whole, in time, and waits to be read */
#define BAUD_DIVIDER 16U  /* 115200 baud at double speed: 117647, 2.1 % fast */

/* --- pulses --- */

enum { IDLE, TO_RISE, TO_FALL };
typedef struct {
    volatile uint8_t state;
    uint16_t width; /* ticks */
} output_t;
static output_t a, b;
static volatile uint32_t rounds; /* of timer 1 */
static volatile uint64_t first_ticks;
static volatile bool has_risen;

/* Ticks since power-on. Interrupts are off. */
static uint64_t ticks_now(void)
{
    uint16_t low = TCNT1;
    uint32_t high = rounds;
    if ((TIFR1 & _BV(TOV1)) && low < 0x8000)
        high++;
    return (uint64_t)high << 16 | low;
}

/* Ticks since power-on of a compare that lies less than one round back. Interrupts are off. */
static uint64_t ticks_at(uint16_t compare)
{
    uint64_t now = ticks_now();
    return now - (uint16_t)((uint16_t)now - compare);
}

ISR(TIMER1_OVF_vect)
{
    rounds++;
}

static void note_rise(uint16_t compare)
{
    if (!has_risen) {
        first_ticks = ticks_at(compare);
        has_risen = true;
    }
}

ISR(TIMER1_COMPA_vect)
{
    if (a.state == TO_RISE) {
        uint16_t rise = OCR1A;
        TCCR1A = (TCCR1A & ~_BV(COM1A0)) | _BV(COM1A1); /* clear at the next compare */
        OCR1A = rise + a.width;
        a.state = TO_FALL;
        note_rise(rise);
    } else {
        TCCR1A &= ~(_BV(COM1A1) | _BV(COM1A0));
        TIMSK1 &= ~_BV(OCIE1A);
        a.state = IDLE;
    }
}

ISR(TIMER1_COMPB_vect)
{
    if (b.state == TO_RISE) {
        uint16_t rise = OCR1B;
        TCCR1A = (TCCR1A & ~_BV(COM1B0)) | _BV(COM1B1);
        OCR1B = rise + b.width;
        b.state = TO_FALL;
        note_rise(rise);
    } else {
        TCCR1A &= ~(_BV(COM1B1) | _BV(COM1B0));
        TIMSK1 &= ~_BV(OCIE1B);
        b.state = IDLE;
    }
}

/* Both outputs low and both compare units at rest. Interrupts are off. */
static void outputs_low(void)
{
    TIMSK1 &= ~(_BV(OCIE1A) | _BV(OCIE1B));
    /* "Clear at compare", and a compare forced now: the unit's own level must be low too, or the
     * next pulse would begin at the moment the unit is connected. */
    TCCR1A = _BV(COM1A1) | _BV(COM1B1);
    TCCR1C = _BV(FOC1A) | _BV(FOC1B);
    TCCR1A = 0;
    PORTB &= ~(_BV(PB1) | _BV(PB2));
    TIFR1 = _BV(OCF1A) | _BV(OCF1B);
    a.state = b.state = IDLE;
}

/* Connect both units for their rising edges. Interrupts are off. */
static void start_pulses(const pulses_t *pulses)
{
    uint32_t delay_us = (uint32_t)(pulses->delay_us < 0 ? -pulses->delay_us : pulses->delay_us);
    uint16_t delay = (uint16_t)((delay_us + TICK_US / 2) / TICK_US);
    uint16_t width = (uint16_t)((pulses->width_us + TICK_US / 2) / TICK_US);
    uint16_t first;
    outputs_low();
    has_risen = false;
    a.width = b.width = width;
    a.state = b.state = TO_RISE;
    first = TCNT1 + LEAD_TICKS;
    OCR1A = pulses->delay_us < 0 ? first + delay : first;
    OCR1B = pulses->delay_us < 0 ? first : first + delay;
    TIFR1 = _BV(OCF1A) | _BV(OCF1B);
    TCCR1A = _BV(COM1A1) | _BV(COM1A0) | _BV(COM1B1) | _BV(COM1B0); /* set at compare */
    TIMSK1 |= _BV(OCIE1A) | _BV(OCIE1B);
}

/* --- arming, power and the watch, all on timer 0's millisecond --- */

static volatile uint16_t armed_ms; /* left; 0: not armed */
static volatile uint8_t watch_state; /* a watch_state_t */
static volatile uint16_t watch_period_ms, watch_silent_ms;
static volatile uint8_t lines_waiting;

static bool has_power(void)
{
    return PIND & _BV(PD2);
}

static void disarm(void)
{
    armed_ms = 0;
    outputs_low();
}

static void end_watch_contact(void)
{
    PORTD &= ~_BV(PD4);
}

static void watch_millisecond(void)
{
    uint16_t due = watch_period_ms;
    if (watch_state != WATCH_KEPT || ++watch_silent_ms < due)
        return;
    if (lines_waiting && watch_silent_ms < due + GRACE_MS)
        return;
    watch_state = WATCH_LATE;
    end_watch_contact();
    disarm();
}

ISR(TIMER0_COMPA_vect)
{
    if (armed_ms)
        armed_ms--;
    if (!has_power())
        disarm();
    watch_millisecond();
}

ISR(INT0_vect) /* the power has gone: shorter than a millisecond is enough */
{
    disarm();
}

bool board_is_powered(void)
{
    return has_power();
}

void board_arm(void)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        armed_ms = ARMED_FOR_MS;
    }
}

bool board_is_armed(void)
{
    bool armed = false;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        armed = armed_ms && has_power();
    }
    return armed;
}

void board_disarm(void)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        disarm();
    }
}

bool board_is_pulsing(void)
{
    return a.state != IDLE || b.state != IDLE;
}

bool board_fire(const pulses_t *pulses, uint64_t *first_us)
{
    bool starts = false;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        starts = armed_ms && has_power() && watch_state != WATCH_LATE;
        if (starts) {
            armed_ms = 0;
            start_pulses(pulses);
        }
    }
    /* Ends: within 32 us the pulse rises, or an interrupt has put both outputs at rest. */
    while (starts && !has_risen)
        starts = board_is_pulsing();
    *first_us = first_ticks * TICK_US;
    return starts;
}

void board_watch(uint16_t period_ms)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        watch_period_ms = period_ms;
        watch_silent_ms = 0;
        if (period_ms) {
            watch_state = WATCH_KEPT;
            PORTD |= _BV(PD4);
        } else {
            watch_state = WATCH_NONE;
            end_watch_contact();
            disarm();
        }
    }
}

void board_beat(void)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        watch_silent_ms = 0;
    }
}

watch_state_t board_watch_state(void)
{
    return (watch_state_t)watch_state;
}

uint16_t board_watch_period_ms(void)
{
    return watch_period_ms;
}

/* --- serial line --- */

#define RECEIVED_SIZE 128U /* powers of two: an index is cut by a mask */
#define TO_SEND_SIZE 64U
static volatile char received[RECEIVED_SIZE], to_send[TO_SEND_SIZE];
static volatile uint8_t received_in, received_out, to_send_in, to_send_out;

ISR(USART_RX_vect)
{
    char character = (char)UDR0;
    uint8_t next = (received_in + 1) & (RECEIVED_SIZE - 1);
    if (next == received_out)
        return; /* full; the line it belongs to is refused: its checksum fails */
    received[received_in] = character;
    received_in = next;
    if (character == '\n')
        lines_waiting++;
}

ISR(USART_UDRE_vect)
{
    if (to_send_in == to_send_out) {
        UCSR0B &= ~_BV(UDRIE0);
    } else {
        UDR0 = (uint8_t)to_send[to_send_out];
        to_send_out = (to_send_out + 1) & (TO_SEND_SIZE - 1);
    }
}

void board_send(char character)
{
    uint8_t next = (to_send_in + 1) & (TO_SEND_SIZE - 1);
    while (next == to_send_out)
        wdt_reset(); /* the line takes one character in 85 us */
    to_send[to_send_in] = character;
    to_send_in = next;
    UCSR0B |= _BV(UDRIE0);
}

static void read_lines(void)
{
    static char line[LONGEST_LINE + 1];
    static uint8_t length;
    char character;
    if (received_in == received_out)
        return;
    character = received[received_out];
    received_out = (received_out + 1) & (RECEIVED_SIZE - 1);
    if (character != '\n') {
        if (length <= LONGEST_LINE)
            line[length++] = character;
        return;
    }
    if (length > 0 && length <= LONGEST_LINE && line[length - 1] == '\r')
        length--;
    if (length > LONGEST_LINE)
        trigger_box_line_too_long();
    else
        trigger_box_line(line, length);
    length = 0;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        lines_waiting--;
    }
}

/* --- start --- */

/* After a reset by the watchdog it stays on, faster than the start of the C library. */
void stop_watchdog(void) __attribute__((naked, used, section(".init3")));
void stop_watchdog(void)
{
    MCUSR = 0;
    wdt_disable();
}

static void start_pins(void)
{
    PORTB &= ~(_BV(PB1) | _BV(PB2));
    DDRB |= _BV(PB1) | _BV(PB2);
    PORTD &= ~(_BV(PD2) | _BV(PD4));
    DDRD = (DDRD & ~_BV(PD2)) | _BV(PD4);
}

static void start_timers(void)
{
    TCCR1A = 0;
    TCCR1B = _BV(CS11) | _BV(CS10); /* timer 1: 16 MHz / 64, free */
    TIMSK1 = _BV(TOIE1);
    TCCR0A = _BV(WGM01); /* timer 0: 16 MHz / 64 / 250 is 1 kHz */
    OCR0A = 249;
    TCCR0B = _BV(CS01) | _BV(CS00);
    TIMSK0 = _BV(OCIE0A);
    EICRA = _BV(ISC01); /* INT0 at a falling edge */
    EIMSK = _BV(INT0);
}

static void start_serial_line(void)
{
    UBRR0 = BAUD_DIVIDER;
    UCSR0A = _BV(U2X0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
}

int main(void)
{
    start_pins();
    start_timers();
    start_serial_line();
    wdt_enable(WDTO_250MS); /* a hung box starts anew: outputs low, nothing armed */
    sei();
    for (;;) {
        wdt_reset();
        read_lines();
    }
}
