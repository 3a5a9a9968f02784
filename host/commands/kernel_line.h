// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/support/log.h"

namespace tactel::host {

/// Returns a sink for the default log of the devices. It reports on stderr work of more than half a second on a
/// device, such as the compilation of kernels that are not in the cache, and ignores all else.
LogSink kernel_line();

}  // namespace tactel::host
