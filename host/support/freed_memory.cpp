// SPDX-License-Identifier: Apache-2.0
#include "host/support/freed_memory.h"

#include <malloc.h>

namespace tactel::host {

void keep_freed_memory([[maybe_unused]] int most) {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 25);  // bytes, the most that the library takes
  mallopt(M_TRIM_THRESHOLD, most);
#endif
}

}  // namespace tactel::host
