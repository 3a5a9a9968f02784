#pragma once
#include <vector>

#include "host/contact_set.h"
#include "host/gap_sweep.h"
#include "host/scene_source.h"

namespace tactel::host {

struct SetOptions {
  Precision precision = Precision::fp32;
  double tolerance = 0;  ///< as GapSweepOptions
};

/// Simulates contacts of a source, range by range. The rows of a contact depend on the source and the contact's number
/// alone, not on the range, the number of threads or what was simulated before.
class SetSimulator {
 public:
  /// Condenses every sensor of the source that the cache does not hold, side by side.
  SetSimulator(Executor& executor, const SceneSource& source, const SetOptions& options);
  ~SetSimulator();

  /// A range of contacts on its way through the three stages of simulate(). Each stage may run in a thread of its own,
  /// on different ranges.
  class Range;
  std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const;
  void run(Range& range, const RunOptions& options = {}) const;
  ContactSet collect(Range& range) const;

  /// Rows of contacts first ... first + count - 1, by contact, then load step: the steps from full indentation on that
  /// have a slippage index. What the sweeps did not solve is solved once more by the exact fallback. Throws ValueError
  /// for a contact whose drawn numbers do not fit each other.
  ContactSet simulate(std::uint64_t first, std::uint64_t count) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

class SetSimulator::Range {
 public:
  virtual ~Range() = default;
  std::uint64_t first = 0, count = 0;  ///< contacts
  std::uint64_t steps = 0;             ///< load increments, indentation included
  double kernel_seconds = 0;
};

}  // namespace tactel::host
