#pragma once
#include <nlohmann/json.hpp>

#include "host/real_sensor_study.h"
#include "host/report_page.h"

namespace tactel::host {

/// section6.json: what was chosen, and of each case errors on what was learnt, on the 11 recalled and on all that were
/// not learnt, as in table2.json; by indenter on the last.
nlohmann::ordered_json real_sensor_json(const RealSensorStudy& study);

/// A record and its sample, errors over draws and seeds, by indenter, and by the number of examples.
void report_real_sensor(ReportPage& page, const RealSensorStudy& study);

}  // namespace tactel::host
