// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/figures/plot.h"
#include "host/studies/paper/inverse_problem.h"
#include "host/studies/paper/real_sensor_study.h"

namespace tactel::host {

/// Returns a figure of the two films of a tactel over a record, with the selected sample.
Figure record_figure(const RealSensorStudy& study);
/// Returns a figure as the paper's Fig. 7: the stresses at the tactels of two contacts, and the selected sample.
Figure frame_figure(const RealSensorStudy& study);
/// Returns a figure of the errors over draws and seeds, by the number of examples and by indenter.
Figure error_figure(const RealSensorStudy& study);

// Shared by figures and tables.

/// Returns the results of 25 examples.
std::vector<const RealSensorResult*> with_25(const RealSensorStudy& study);
/// Returns the mean error by indenter on the 80 contacts outside of the 25 learned ones. They include some of
/// each indenter's 15.
Spread of_indenter(const RealSensorResult& result, int indenter);
/// Returns the index in study.contacts.
std::size_t place_of(const RealSensorStudy& study, const RealContact& contact);

}  // namespace tactel::host
