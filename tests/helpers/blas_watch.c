/* Preloaded before numpy's OpenBLAS: writes which line of Python calls a function of BLAS or LAPACK, then calls it.

   BLAS_WATCH_LOG names the file, and BLAS_WATCH_ROOT the folder in which the innermost frame is looked for. A call in an
   import of another package, or from outside the folder, is not written. x86-64 and Linux only. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WEAK __attribute__((weak)) /* the library is preloaded into programs without Python, too */
extern int PyGILState_Ensure(void) WEAK;
extern void PyGILState_Release(int) WEAK;
extern void *PyEval_GetFrame(void) WEAK;
extern void *PyFrame_GetBack(void *) WEAK;
extern void *PyFrame_GetCode(void *) WEAK;
extern int PyFrame_GetLineNumber(void *) WEAK;
extern void *PyObject_GetAttrString(void *, const char *) WEAK;
extern const char *PyUnicode_AsUTF8(void *) WEAK;
extern void Py_IncRef(void *) WEAK;
extern void Py_DecRef(void *) WEAK;

static void *openblas;

static int find(struct dl_phdr_info *info, size_t size, void *unused)
{
    if (strstr(info->dlpi_name, "scipy_openblas64_"))
        openblas = dlopen(info->dlpi_name, RTLD_LAZY | RTLD_NOLOAD);
    return openblas != NULL;
}

static void write_frame(const char *function)
{
    const char *log = getenv("BLAS_WATCH_LOG"), *root = getenv("BLAS_WATCH_ROOT");
    if (!log || !root)
        return;
    int lock = PyGILState_Ensure(), done = 0;
    void *frame = PyEval_GetFrame();
    if (frame)
        Py_IncRef(frame);
    while (frame && !done) {
        void *code = PyFrame_GetCode(frame), *name = PyObject_GetAttrString(code, "co_filename");
        const char *file = PyUnicode_AsUTF8(name);
        if (!strncmp(file, "<frozen importlib", 17)) {
            done = 1;
        } else if (!strncmp(file, root, strlen(root))) {
            int target = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
            dprintf(target, "%s\t%s\t%d\n", function, file, PyFrame_GetLineNumber(frame));
            close(target);
            done = 1;
        }
        Py_DecRef(name);
        Py_DecRef(code);
        void *back = PyFrame_GetBack(frame);
        Py_DecRef(frame);
        frame = back;
    }
    if (frame)
        Py_DecRef(frame);
    PyGILState_Release(lock);
}

__attribute__((used, visibility("hidden"))) void *watched_call(const char *function)
{
    if (!openblas)
        dl_iterate_phdr(find, NULL);
    void *real = openblas ? dlsym(openblas, function) : NULL;
    if (!real)
        abort();
    write_frame(function);
    return real;
}

/* Keep the registers of the arguments, note the call, and jump to the function with the stack as it was. */
#define WATCH(function)                                                                                               \
    __asm__(".text\n.globl " #function "\n.type " #function ",@function\n" #function ":\n"                            \
            "push %rdi\npush %rsi\npush %rdx\npush %rcx\npush %r8\npush %r9\npush %rax\nsub $128, %rsp\n"             \
            "movups %xmm0, (%rsp)\nmovups %xmm1, 16(%rsp)\nmovups %xmm2, 32(%rsp)\nmovups %xmm3, 48(%rsp)\n"          \
            "movups %xmm4, 64(%rsp)\nmovups %xmm5, 80(%rsp)\nmovups %xmm6, 96(%rsp)\nmovups %xmm7, 112(%rsp)\n"       \
            "lea name_of_" #function "(%rip), %rdi\ncall watched_call\nmov %rax, %r11\n"                              \
            "movups (%rsp), %xmm0\nmovups 16(%rsp), %xmm1\nmovups 32(%rsp), %xmm2\nmovups 48(%rsp), %xmm3\n"          \
            "movups 64(%rsp), %xmm4\nmovups 80(%rsp), %xmm5\nmovups 96(%rsp), %xmm6\nmovups 112(%rsp), %xmm7\n"       \
            "add $128, %rsp\npop %rax\npop %r9\npop %r8\npop %rcx\npop %rdx\npop %rsi\npop %rdi\njmp *%r11\n"         \
            ".section .rodata\nname_of_" #function ": .string \"" #function "\"\n.text\n");

/* Every function of double precision that numpy calls. */
WATCH(scipy_cblas_daxpy64_)
WATCH(scipy_cblas_ddot64_)
WATCH(scipy_cblas_dgemm64_)
WATCH(scipy_cblas_dgemv64_)
WATCH(scipy_cblas_dsyrk64_)
WATCH(scipy_dcopy_64_)
WATCH(scipy_dgeev_64_)
WATCH(scipy_dgelsd_64_)
WATCH(scipy_dgeqrf_64_)
WATCH(scipy_dgesdd_64_)
WATCH(scipy_dgesv_64_)
WATCH(scipy_dgetrf_64_)
WATCH(scipy_dorgqr_64_)
WATCH(scipy_dpotrf_64_)
WATCH(scipy_dsyevd_64_)
