// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "host/figures/page.h"
#include "host/studies/extremes/extremes.h"

namespace tactel::host {

/// Returns the page of the table of extremes and of the findings beside it.
Page extremes_page(const std::vector<Extreme>& extremes, const std::vector<ExtremeFinding>& findings,
                   const std::string& device);

}  // namespace tactel::host
