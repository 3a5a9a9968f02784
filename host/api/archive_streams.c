/* SPDX-License-Identifier: Apache-2.0 */
/* stdout and stderr of HDF5's archive. Debian compiles it for programs, which reach both in a way that a shared library cannot. The
   linker (--wrap) gives it these pointers in their place. */
#include <stdio.h>

extern FILE* real_stdout __asm__("__real_stdout");
extern FILE* real_stderr __asm__("__real_stderr");
FILE* wrapped_stdout __asm__("__wrap_stdout");
FILE* wrapped_stderr __asm__("__wrap_stderr");

__attribute__((constructor)) static void take_streams(void) {
  wrapped_stdout = real_stdout;
  wrapped_stderr = real_stderr;
}
