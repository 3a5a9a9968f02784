// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>

#include "host/contact/lines/gap_sweep.h"
#include "host/scenes/ladder.h"
#include "host/scenes/paper_sets.h"
#include "host/scenes/scene_source.h"
#include "host/sets/contact_set.h"
#include "host/support/seconds.h"

namespace tactel::host {

/// Time of the stages of a set, s, summed over threads.
struct StageSeconds {
  double draw = 0, lay_out = 0;       ///< contacts; their numbers in lanes
  double solve = 0, solve_again = 0;  ///< in kernels and waiting for them; contacts that need more than their kernel
  double gather = 0, write = 0;       ///< rows; rows to the disk
  double all() const { return draw + lay_out + solve + solve_again + gather + write; }
  StageSeconds& operator+=(const StageSeconds& more) {
    draw += more.draw, lay_out += more.lay_out, solve += more.solve, solve_again += more.solve_again;
    gather += more.gather, write += more.write;
    return *this;
  }
};

struct SetOptions {
  Precision precision = Precision::fp32;
  double tolerance = 0;            ///< as GapSweepOptions; 0 with patches: the rung's
  double accept = 0;               ///< as GapSweepOptions
  std::optional<Rung> patch{};     ///< contacts on patches of this rung, with its precision and tolerance; none: on the
                                   ///< mesh of their sensor
  PadRung pad = usual_pad_rung();  ///< of contacts on pads
};

/// Models contacts of lines by a rung.
void model_on(const Rung& rung, SceneSource& source, SetOptions& options);

/// Returns all datasets that the set of a source has.
SetColumns columns_of(const SceneSource& source);
SetColumns columns_of(const PadSource& source);
SetColumns columns_of(const AnySource& source);

/// Simulates contacts of a source, range by range. The rows of a contact depend on the source and the number of
/// the contact alone. They do not depend on the range, the number of threads or earlier simulations.
class SetSimulator {
 public:
  /// Condenses in parallel every sensor of the source that the cache does not hold.
  SetSimulator(Executor& executor, const SceneSource& source, const SetOptions& options);
  SetSimulator(Executor& executor, const PadSource& source, const SetOptions& options);
  SetSimulator(Executor& executor, const AnySource& source, const SetOptions& options);
  ~SetSimulator();
  SetSimulator(SetSimulator&& other) noexcept;

  /// A range of contacts in the three stages of simulate(). Threads may call them at once, on different ranges. A
  /// range is collected once.
  class Range;
  struct State;
  std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const;
  void run(Range& range, const RunOptions& options = {}) const;
  ContactSet collect(Range& range) const;

  /// Returns the rows of contacts first ... first + count - 1, by contact, then load step. The rows are the
  /// steps from full indentation on (or all: SceneSource::press_rows) that have a slippage index. The exact fallback
  /// solves contacts that the sweeps did not solve. Throws ValueError for a contact whose drawn numbers contradict each
  /// other.
  ContactSet simulate(std::uint64_t first, std::uint64_t count) const;

 private:
  std::unique_ptr<State> state_;
};

class SetSimulator::Range {
 public:
  virtual ~Range() = default;
  std::uint64_t first = 0, count = 0;            ///< contacts
  std::uint64_t steps = 0;                       ///< load increments, indentation included
  std::atomic<std::size_t>* answered = nullptr;  ///< counts contacts as their answers become known; none: nobody asks
  double kernel_seconds = 0;                     ///< in kernels
  StageSeconds seconds{};
};

/// The simulator of one kind of contact.
struct SetSimulator::State {
  virtual ~State() = default;
  virtual std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const = 0;
  virtual void run(Range& range, const RunOptions& options) const = 0;
  virtual ContactSet collect(Range& range) = 0;
};

/// Simulates a family by SetSimulator. Warns on the device's log of contacts that stay unsolved.
ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance);

/// Returns a warning about contacts that stayed unsolved, with their count; none where there are none.
std::optional<std::string> unsolved_warning(const ContactSet& set);

}  // namespace tactel::host
