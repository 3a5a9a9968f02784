// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "nn/frame_set.h"

namespace tactel::host {

/// Frames in blocks, so that a few blocks at most are in memory. Block k is a function of the stream and k.
class FrameStream {
 public:
  virtual ~FrameStream() = default;
  /// Returns block k; without rows where none of them has an answer. Throws ConfigError, naming file and row, for a
  /// frame that no network can learn from.
  virtual nn::FrameSet block(std::uint64_t k) = 0;
  virtual int at_once() const { return 0; }  ///< threads that may take blocks at once; 0: blocks are not made ahead
  virtual void stop() {}                     ///< blocks under way end soon; they and all others are then of no use
  virtual std::uint64_t blocks() const = 0;  ///< until the rows repeat; 1 for an endless stream
  virtual int inputs() const = 0;            ///< of a frame
  virtual std::string name() const = 0;      ///< its file
  /// Returns what its user should know of the frames.
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Returns all inputs of the blocks, as text.
  virtual std::string description() const = 0;
};

}  // namespace tactel::host
