#pragma once
#include <cstdint>

namespace tactel::nn {

/// What became of a frame on its way to a slippage index. No output is NaN with status `ok`.
enum class FrameStatus : std::uint8_t {
  ok = 0,
  no_stress = 1,   ///< scaling by the frame's own stress found none; the network saw zeros
  not_finite = 2,  ///< the frame holds NaN or infinity; no slippage index (NaN)
  overflow = 3,    ///< the frame is finite, but a sum inside the network was not; no slippage index (NaN)
};

/// "ok", "no stress", "not finite", "overflow".
const char* name(FrameStatus status);

}  // namespace tactel::nn
