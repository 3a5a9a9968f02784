// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "host/figures/page.h"
#include "host/studies/paper/real_sensor_study.h"

namespace tactel::host {

/// Returns section6.json: the choice, and for each case the errors on the learned contacts, on the 11 recalled
/// and on all others, as in table2.json; on the last also by indenter.
nlohmann::ordered_json real_sensor_json(const RealSensorStudy& study);

/// Adds to the report a record and its sample, and errors over draws and seeds, and by indenter.
void report_real_sensor(Page& page, const RealSensorStudy& study);

}  // namespace tactel::host
