// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "fem/layer/sensor_family.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Makes tables 0 ... count - 1 on all threads, and tells the device's log how many are made.
void make_tables(Executor& executor, std::size_t count, const std::function<void(std::size_t)>& make);

/// Returns the tables of all sensors of a range, made on all threads.
fem::SensorFamily sensor_family(Executor& executor, const fem::SensorRange& range, bool sides = true);

}  // namespace tactel::host
