// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "host/device/executor.h"
#include "host/scenes/scene_source.h"
#include "host/sets/set_simulator.h"
#include "nn/frame_set.h"
#include "nn/presentation_order.h"

namespace tactel::host {

/// What a network learns of the rows: shown_rows.
struct ShownRows {
  nn::InputHistory history{};
  bool magnitude = false;
};

/// Frames in blocks, so that at most one block is in memory. Block k is a function of the stream and k.
class FrameStream {
 public:
  virtual ~FrameStream() = default;
  /// Returns block k; without rows where none of them has an answer. Throws ConfigError, naming file and row, for a
  /// frame that no network can learn from.
  virtual nn::FrameSet block(std::uint64_t k) = 0;
  virtual int at_once() const { return 0; }  ///< threads that may take blocks at once; 0: blocks are not made ahead
  virtual void stop() {}                     ///< blocks under way end soon; they and all others are then of no use
  virtual std::uint64_t blocks() const = 0;  ///< until the rows repeat; 1 for an endless stream
  virtual int inputs() const = 0;            ///< of all frames of a row
  /// Returns what its user should know of the frames.
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Returns all inputs of the blocks, as text.
  virtual std::string description() const = 0;
};

/// Returns an endless stream of contacts, simulated on demand and never stored. Block k holds `contacts` new
/// ones. The stream is the only user of `executor` while blocks are taken.
std::unique_ptr<FrameStream> simulated_stream(Executor& executor, const std::filesystem::path& sweep_file,
                                              std::uint64_t contacts, const SetOptions& options,
                                              const ShownRows& shown = {});

/// Returns a stream of the rows of a set file, `rows` at a time. Every pass takes the blocks in the order of the
/// file, or in another permutation drawn from `seed`. Rows over tolerance or without a finite slippage index are
/// excluded. With history, a block takes whole contacts: those whose first row is among its rows. Throws ConfigError
/// for a set without rows.
std::unique_ptr<FrameStream> file_stream(const std::filesystem::path& set_file, std::uint64_t rows, std::uint64_t seed,
                                         nn::PresentationOrder order = nn::PresentationOrder::permuted,
                                         const ShownRows& shown = {});

}  // namespace tactel::host
