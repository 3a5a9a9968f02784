// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/contact/line_contacts.h"
#include "host/contact/stream_of.h"

namespace tactel::host {

/// The stream of contacts of the line.
using ContactStream = StreamOf<LineContacts>;
extern template class StreamOf<LineContacts>;

/// Solves scenes on the meshes of their sensors.
std::vector<fem::ContactSolution> solve_on_meshes(Executor& executor, std::span<const fem::Scene> scenes,
                                                  Precision precision, const GapSweepOptions& options = {});

}  // namespace tactel::host
