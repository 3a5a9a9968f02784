// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/device/executor.h"

namespace tactel::testing {

/// That of the default device, once a process.
inline host::Executor& executor() {
  static host::Executor executor{host::Device()};
  return executor;
}

}  // namespace tactel::testing
