#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "host/executor.h"
#include "host/scene_source.h"
#include "host/set_simulator.h"
#include "nn/frame_set.h"

namespace tactel::host {

/// Frames that come block by block, so that no more than a block is ever in memory. Block k is a function of the
/// stream and k.
class FrameStream {
 public:
  virtual ~FrameStream() = default;
  virtual nn::FrameSet block(std::uint64_t k) = 0;
  virtual int inputs() const = 0;
  /// All that the blocks depend on, as text.
  virtual std::string description() const = 0;
};

/// Contacts simulated when they are asked for, never stored, without end: block k holds `contacts` fresh ones.
std::unique_ptr<FrameStream> simulated_stream(Executor& executor, const std::filesystem::path& sweep_file,
                                              std::uint64_t contacts, const SetOptions& options);

/// The rows of a set file, `rows` at a time; every pass takes the blocks in another order, drawn from `seed`. Rows over
/// tolerance or without a finite slippage index are left out.
std::unique_ptr<FrameStream> file_stream(const std::filesystem::path& set_file, std::uint64_t rows, std::uint64_t seed);

}  // namespace tactel::host
