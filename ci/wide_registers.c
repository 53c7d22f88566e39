/* Lets a Linux in user space run on processors whose extended register state is wider than it knows.
 *
 * linux.uml moves the floating-point state of its processes with PTRACE_GETREGSET and PTRACE_SETREGSET and a buffer of
 * fixed size. Where the processor's state is larger (AMX), the host cuts the answer to the first call short and refuses
 * the second one. This library, preloaded by ci/can_kernel, reads and writes the whole state and hands linux.uml the
 * part that it has room for; what lies behind it is the state of units that its processes never use.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

typedef long (*ptrace_function)(int, pid_t, void *, void *);

static unsigned char whole[65536] __attribute__((aligned(64)));

long ptrace(enum __ptrace_request request, ...)
{
    static ptrace_function host;
    va_list rest;
    va_start(rest, request);
    pid_t pid = va_arg(rest, pid_t);
    void *address = va_arg(rest, void *);
    void *data = va_arg(rest, void *);
    va_end(rest);
    if (!host)
        host = (ptrace_function)dlsym(RTLD_NEXT, "ptrace");

    int reads = request == PTRACE_GETREGSET;
    if ((!reads && request != PTRACE_SETREGSET) || address != (void *)NT_X86_XSTATE)
        return host(request, pid, address, data);

    struct iovec *part = data;
    struct iovec all = {whole, sizeof whole};
    long result = host(PTRACE_GETREGSET, pid, address, &all);
    if (result < 0)
        return result;
    if (part->iov_len > all.iov_len)
        part->iov_len = all.iov_len;
    if (reads) {
        memcpy(part->iov_base, whole, part->iov_len);
        return result;
    }
    memcpy(whole, part->iov_base, part->iov_len);
    return host(PTRACE_SETREGSET, pid, address, &all);
}
