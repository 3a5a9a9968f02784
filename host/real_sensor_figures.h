#pragma once
#include "host/inverse_problem.h"
#include "host/plot.h"
#include "host/real_sensor_study.h"

namespace tactel::host {

/// The two films of a tactel over a record, with the sample that is taken.
Figure record_figure(const RealSensorStudy& study);
/// As the paper's Fig. 7: of two contacts the stresses at the tactels, and the sample taken.
Figure frame_figure(const RealSensorStudy& study);
/// Errors over draws and seeds, by the number of examples, and by indenter.
Figure error_figure(const RealSensorStudy& study);

// What figures and tables both show.

/// The results of 25 examples.
std::vector<const RealSensorResult*> with_25(const RealSensorStudy& study);
/// Mean error by indenter on the 80 contacts that were not learnt of 25: some of each indenter's 15 are among them.
Spread of_indenter(const RealSensorResult& result, int indenter);
/// In study.contacts.
std::size_t place_of(const RealSensorStudy& study, const RealContact& contact);

}  // namespace tactel::host
