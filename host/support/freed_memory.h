// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tactel::host {

/// Lets the process keep memory that it gives back, up to `most` bytes, for arrays that are taken and freed again and
/// again: the system would clear every page of it anew.
void keep_freed_memory(int most);

}  // namespace tactel::host
