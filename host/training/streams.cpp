// SPDX-License-Identifier: Apache-2.0
#include "host/training/streams.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <string>

#include "host/answers/planner.h"
#include "host/scenes/scene_source.h"
#include "host/scenes/sweep_file.h"
#include "host/scenes/unit_warnings.h"
#include "host/sets/contact_set.h"
#include "host/support/errors.h"
#include "host/training/answered_rows.h"

namespace tactel::host {
namespace {

/// Threads of a simulated stream, at most: each holds a block of some 100 MB. At least two: one prepares contacts while
/// the other's kernels run.
constexpr int most_threads = 8;

nn::FrameSet as_shown(nn::FrameSet rows, const ShownRows& shown, const std::string& name) {
  if (shown.history == nn::InputHistory{} && !shown.magnitude) return rows;
  return shown_rows(rows, shown.history, shown.magnitude, name);
}

/// Empty for single frames of S.
std::string text_of(const ShownRows& shown) {
  const nn::InputHistory& h = shown.history;
  return (h.path() > 1 ? fmt::format(" history {}:{} change {:a}", h.path(), h.stride, h.change) : "") +
         (h.rest ? " rest" : "") + (h.friction ? " friction" : "") + (shown.magnitude ? " magnitude" : "") +
         (shown.markers ? " markers" : "") +
         (shown.target != nn::Target::slip_index ? fmt::format(" {}", nn::name(shown.target)) : "");
}

/// Models the contacts of a sweep by the rung of a name; an empty one changes nothing.
Sweep modelled(Sweep sweep, const std::string& name, SetOptions& options) {
  if (name.empty()) return sweep;
  SolveOptions asked;
  asked.rung = name;
  if (std::holds_alternative<PadSource>(sweep.source))
    options.pad = named_rung_for_many<PadRung>(asked).value();
  else
    model_on(named_rung_for_many(asked).value(), std::get<SceneSource>(sweep.source), options);
  return sweep;
}

class SimulatedStream : public FrameStream {
 public:
  SimulatedStream(Executor& executor, const std::filesystem::path& file, std::uint64_t contacts,
                  const std::string& rung, const SetOptions& options, const ShownRows& shown)
      : options_(options),
        rung_(rung),
        sweep_(modelled(read_sweep(file), rung, options_)),
        name_(file.string()),
        contacts_(contacts),
        shown_(shown),
        threads_(std::clamp(executor.threads(), 2, most_threads)),
        simulator_(executor, sweep_.source, options_) {
    if (!sweep_.contacts().endless())
      throw ConfigError(name_, "sweep.set", "a listed set", "left out: a stream draws its contacts (sweep.contacts)");
    require_answers(columns_of(sweep_.source), name_, shown_.target, shown_.markers);
  }
  nn::FrameSet block(std::uint64_t k) override {
    const auto range = simulator_.prepare(k * contacts_, contacts_);
    simulator_.run(*range, {.progress = [this](std::size_t, std::size_t) { return !stopped_; }});
    if (stopped_) return {};
    AnsweredRows rows = answered_rows(simulator_.collect(*range), name_, shown_.target, shown_.markers);
    check_learnable(rows, name_);
    return as_shown(std::move(rows.frames), shown_, name_);
  }
  int at_once() const override { return threads_; }
  void stop() override { stopped_ = true; }
  std::uint64_t blocks() const override { return 1; }
  std::string name() const override { return name_; }
  int inputs() const override { return frame_inputs(columns_of(sweep_.source), shown_.markers); }
  std::vector<std::string> warnings() const override {
    std::vector<std::string> all = unit_warnings(sweep_.source);
    const auto* lines = std::get_if<SceneSource>(&sweep_.source);
    if (lines && lines->model() == fem::SurfaceModel::patch && tactels_at_ends(*lines))
      all.push_back(tactels_at_ends_text);
    for (std::string& warning : all) warning.insert(0, name_ + ": ");
    return all;
  }
  std::string description() const override {
    return "tactel " TACTEL_VERSION " simulated " + std::to_string(contacts_) + " contacts a block, precision " +
           std::to_string(static_cast<int>(options_.precision)) + (rung_.empty() ? "" : " rung " + rung_) +
           text_of(shown_) + "\n" + sweep_.text;
  }

 private:
  SetOptions options_;
  std::string rung_;
  Sweep sweep_;
  std::string name_;
  std::uint64_t contacts_;
  ShownRows shown_;
  int threads_;
  SetSimulator simulator_;
  std::atomic<bool> stopped_ = false;
};

class FileStream : public FrameStream {
 public:
  FileStream(const std::filesystem::path& file, std::uint64_t rows, std::uint64_t seed, nn::PresentationOrder order,
             const ShownRows& shown)
      : name_(file.string()),
        reader_(file, unread(shown.markers)),
        rows_(rows),
        seed_(seed),
        how_(order),
        shown_(shown) {
    require_answers(reader_.columns(), name_, shown_.target, shown_.markers);
    if (reader_.rows() == 0) throw ConfigError(name_, "slip_index", "0 rows", "at least one row to learn from");
  }

  nn::FrameSet block(std::uint64_t k) override {
    const auto pass = static_cast<std::uint32_t>(k / blocks());
    if (order_.empty() || pass != pass_)
      order_ = nn::presentation_order(how_, seed_, pass, static_cast<std::uint32_t>(blocks()));
    pass_ = pass;
    std::uint64_t first = order_[k % blocks()] * rows_, end = std::min(first + rows_, reader_.rows());
    if (shown_.history.frames > 1) first = contact_border(first), end = contact_border(end);
    AnsweredRows rows = find_answered_rows(reader_.read(first, end - first), shown_.target, shown_.markers);
    check_learnable(rows, name_, first);
    if (rows.row.empty()) return std::move(rows.frames);
    return as_shown(std::move(rows.frames), shown_, name_);
  }
  std::uint64_t blocks() const override { return (reader_.rows() + rows_ - 1) / rows_; }
  std::string name() const override { return name_; }
  int inputs() const override { return frame_inputs(reader_.columns(), shown_.markers); }
  std::string description() const override {
    return "file " + std::to_string(reader_.rows()) + " rows, " + std::to_string(rows_) + " a block, " +
           nn::name(how_) + ", seed " + std::to_string(seed_) + text_of(shown_) + "\n" + contact_set_sweep(name_);
  }

 private:
  /// The first row from `row` on that begins a contact; the end of the set where there is none.
  std::uint64_t contact_border(std::uint64_t row) const {
    constexpr std::uint64_t at_once = 256;
    if (row == 0) return row;
    std::optional<std::uint64_t> before;
    for (std::uint64_t at = row - 1; at < reader_.rows(); at += at_once) {
      const ContactSet part = reader_.read(at, std::min(at_once, reader_.rows() - at));
      for (std::size_t i = 0; i < part.rows(); ++i) {
        if (before && part.contact[i] != *before) return at + i;
        before = part.contact[i];
      }
    }
    return reader_.rows();
  }

  std::string name_;
  ContactSetReader reader_;
  std::uint64_t rows_, seed_;
  nn::PresentationOrder how_;
  ShownRows shown_;
  std::uint32_t pass_ = 0;
  std::vector<std::uint32_t> order_;
};

}  // namespace

std::unique_ptr<FrameStream> simulated_stream(Executor& executor, const std::filesystem::path& sweep_file,
                                              std::uint64_t contacts, const std::string& rung,
                                              const SetOptions& options, const ShownRows& shown) {
  return std::make_unique<SimulatedStream>(executor, sweep_file, contacts, rung, options, shown);
}

std::unique_ptr<FrameStream> file_stream(const std::filesystem::path& set_file, std::uint64_t rows, std::uint64_t seed,
                                         nn::PresentationOrder order, const ShownRows& shown) {
  return std::make_unique<FileStream>(set_file, rows, seed, order, shown);
}

}  // namespace tactel::host
