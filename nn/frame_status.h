// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace tactel::nn {

/// Status of the evaluation of a frame. No output with status `ok` is NaN.
enum class FrameStatus : std::uint8_t {
  ok = 0,
  no_stress = 1,   ///< scaling by frame, but the frame has no normal stress; the network received zeros
  not_finite = 2,  ///< the frame contains NaN or infinity; the slippage index is NaN
  overflow = 3,    ///< the frame is finite, but a sum inside the network is not; the slippage index is NaN
};

/// Returns "ok", "no stress", "not finite" or "overflow".
const char* name(FrameStatus status);

}  // namespace tactel::nn
