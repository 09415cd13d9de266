/* From reset to main on a Cortex-M with an FPU, and back to the debugger with main's status. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

extern char stack_top[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void initialise_monitor_handles(void); /* newlib's: opens the debugger's terminal */
extern int main(void);
void reset(void);

#define CPACR (*(volatile uint32_t *)0xE000ED88u) /* coprocessor access control */
#define FPU (0xFu << 20)                          /* full access to coprocessors 10 and 11 */
#define FAULT 99                                  /* exit status of a processor's fault */

void reset(void) {
    CPACR |= FPU;
    __asm__ volatile("dsb\n\tisb");
    memcpy(data_begin, data_load, (size_t)(data_end - data_begin));
    memset(bss_begin, 0, (size_t)(bss_end - bss_begin));
    initialise_monitor_handles();
    const int status = main();
    fflush(NULL);
    _exit(status);
}

static void fault(void) {
    _exit(FAULT);
}

/* Stack, reset, NMI, and the faults: hard, memory management, bus, usage. */
static const void *const vectors[] __attribute__((section(".vectors"), used)) = {
    stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};
