/* Runs the trigger box's firmware on a simulated ATmega328P and logs its pins by clock cycles.
 *
 *   bench trigger_box.elf
 *
 * Commands, a line each, on standard input:
 *   power 0|1      give or take the outputs' power (PD2)
 *   send HEX       bytes for the serial line, one after another at its own speed
 *   run CYCLES     let the chip run that long; answered by `done CYCLE`
 *   reset          reset the chip now
 *   pty            join the serial line to a pseudo-terminal, answered by `pty PATH`, and run no
 *                  faster than the clock on the wall until the next line comes in
 *
 * Output, with the cycle (of 62.5 ns) at which it happened:
 *   edge CYCLE A|B|W LEVEL     outputs a and b, contact of the watch
 *   byte CYCLE HEX             from the serial line
 */
#include <fcntl.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <avr_ioport.h>
#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_elf.h>

#define CLOCK_HZ 16000000ULL
#define SLICE_CYCLES 16000ULL /* of free running: 1 ms */
#define QUEUE_SIZE 65536U

static avr_t *chip;
static unsigned char queue[QUEUE_SIZE];
static size_t queue_in, queue_out;
static bool may_send = true, is_powered = false;
static int terminal = -1;

static void die(const char *why)
{
    fprintf(stderr, "bench: %s\n", why);
    exit(1);
}

/* --- pins and serial line --- */

static void on_edge(struct avr_irq_t *irq, uint32_t value, void *name)
{
    if ((irq->value ^ value) & 1)
        printf("edge %llu %s %u\n", (unsigned long long)chip->cycle, (char *)name, value & 1);
}

static void on_byte(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    unsigned char byte = (unsigned char)value;
    (void)irq, (void)unused;
    printf("byte %llu %02x\n", (unsigned long long)chip->cycle, byte);
    if (terminal >= 0 && write(terminal, &byte, 1) != 1)
        die("the pseudo-terminal takes no byte");
}

static void on_ready(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    (void)irq, (void)value, (void)unused;
    may_send = true;
}

static void on_full(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    (void)irq, (void)value, (void)unused;
    may_send = false;
}

static avr_irq_t *pin(char port, int number)
{
    return avr_io_getirq(chip, AVR_IOCTL_IOPORT_GETIRQ(port), number);
}

static avr_irq_t *serial(int which)
{
    return avr_io_getirq(chip, AVR_IOCTL_UART_GETIRQ('0'), which);
}

static void wire(void)
{
    uint32_t flags = 0;
    avr_irq_register_notify(pin('B', 1), on_edge, "A");
    avr_irq_register_notify(pin('B', 2), on_edge, "B");
    avr_irq_register_notify(pin('D', 4), on_edge, "W");
    avr_ioctl(chip, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(chip, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(serial(UART_IRQ_OUTPUT), on_byte, NULL);
    avr_irq_register_notify(serial(UART_IRQ_OUT_XON), on_ready, NULL);
    avr_irq_register_notify(serial(UART_IRQ_OUT_XOFF), on_full, NULL);
}

/* --- running --- */

static void feed(void)
{
    while (may_send && queue_out != queue_in) {
        avr_raise_irq(serial(UART_IRQ_INPUT), queue[queue_out]);
        queue_out = (queue_out + 1) % QUEUE_SIZE;
    }
}

static void push(unsigned char byte)
{
    queue[queue_in] = byte;
    queue_in = (queue_in + 1) % QUEUE_SIZE;
    if (queue_in == queue_out)
        die("more bytes wait than the queue holds");
}

static void run_to(avr_cycle_count_t end)
{
    while (chip->cycle < end) {
        int state;
        feed();
        state = avr_run(chip);
        if (state == cpu_Done || state == cpu_Crashed)
            die("the firmware has crashed");
    }
}

static int open_terminal(void)
{
    struct termios raw;
    int host = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (host < 0 || grantpt(host) || unlockpt(host))
        die("no pseudo-terminal");
    /* Its other end stays open, so that a host that hangs up and comes back finds it. */
    if (open(ptsname(host), O_RDWR | O_NOCTTY) < 0 || tcgetattr(host, &raw))
        die("no pseudo-terminal");
    cfmakeraw(&raw);
    tcsetattr(host, TCSANOW, &raw);
    return host;
}

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Run until a line waits on standard input; the chip's clock never runs before the wall's. */
static void run_beside_the_wall(void)
{
    double began_s = now_s();
    avr_cycle_count_t began = chip->cycle;
    for (;;) {
        struct pollfd waiting[] = {{.fd = 0, .events = POLLIN}, {.fd = terminal, .events = POLLIN}};
        double ahead_s = (double)(chip->cycle - began) / CLOCK_HZ - (now_s() - began_s);
        poll(waiting, 2, ahead_s > 1e-3 ? 1 : 0);
        if (waiting[0].revents)
            return;
        if (waiting[1].revents & POLLIN) {
            unsigned char bytes[256];
            ssize_t count = read(terminal, bytes, sizeof bytes);
            for (ssize_t at = 0; at < count; at++)
                push(bytes[at]);
        }
        if (ahead_s <= 1e-3)
            run_to(chip->cycle + SLICE_CYCLES);
        fflush(stdout);
    }
}

static void send_hexadecimal(const char *text)
{
    unsigned byte;
    for (; sscanf(text, "%2x", &byte) == 1; text += 2)
        push((unsigned char)byte);
}

static void obey(char *command)
{
    command[strcspn(command, "\n")] = '\0';
    if (strncmp(command, "power ", 6) == 0) {
        is_powered = command[6] == '1';
        avr_raise_irq(pin('D', 2), is_powered);
    } else if (strncmp(command, "send ", 5) == 0) {
        send_hexadecimal(command + 5);
    } else if (strncmp(command, "run ", 4) == 0) {
        run_to(chip->cycle + strtoull(command + 4, NULL, 10));
        printf("done %llu\n", (unsigned long long)chip->cycle);
    } else if (strcmp(command, "reset") == 0) {
        queue_out = queue_in;
        avr_reset(chip);
        /* Pins that nothing drives are pulled low on the board. */
        avr_raise_irq(pin('B', 1), 0);
        avr_raise_irq(pin('B', 2), 0);
        avr_raise_irq(pin('D', 4), 0);
        avr_raise_irq(pin('D', 2), 0); /* the port has lost its level, and takes changes only */
        avr_raise_irq(pin('D', 2), is_powered);
    } else if (strcmp(command, "pty") == 0) {
        terminal = terminal < 0 ? open_terminal() : terminal;
        printf("pty %s\n", ptsname(terminal));
        fflush(stdout);
        run_beside_the_wall();
    } else {
        die("unknown command");
    }
    fflush(stdout);
}

int main(int count, char *arguments[])
{
    static char command[2 * QUEUE_SIZE];
    elf_firmware_t firmware = {0};
    if (count != 2 || elf_read_firmware(arguments[1], &firmware))
        die("give the firmware's .elf file");
    chip = avr_make_mcu_by_name("atmega328p");
    if (!chip)
        die("this simavr knows no atmega328p");
    avr_init(chip);
    chip->frequency = CLOCK_HZ;
    avr_load_firmware(chip, &firmware);
    chip->log = LOG_ERROR;
    wire();
    setvbuf(stdin, NULL, _IONBF, 0); /* what is read is what poll saw */
    while (fgets(command, sizeof command, stdin))
        obey(command);
    return 0;
}
