// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_production.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "host/support/errors.h"
#include "host/support/host_limits.h"
#include "host/support/stop_scope.h"

namespace tactel::host {
namespace {

/// Threads of a device, at most: each holds a chunk of some 100 MB.
constexpr int most_threads = 8;

/// What the devices share: which chunk is next, the spool, and whether to stop.
class Production {
 public:
  Production(const AnySource& source, SetSpool& spool, const std::vector<std::uint64_t>& chunks,
             const ProductionOptions& options)
      : source_(source), spool_(spool), options_(options), chunks_(chunks) {
    for (const std::uint64_t number : chunks_) contacts_ += contacts_of(number);
  }

  const AnySource& source() const { return source_; }
  std::uint64_t chunk() const { return contacts_of_chunk(source_); }
  std::optional<std::uint64_t> next() {
    const std::size_t i = next_++;
    return stopped_ || i >= chunks_.size() ? std::nullopt : std::optional(chunks_[i]);
  }
  std::uint64_t contacts_of(std::uint64_t number) const {
    return std::min(chunk(), common(source_).contacts() - number * chunk());
  }
  std::atomic<std::size_t>* answered() { return &answered_; }
  void add(std::uint64_t number, SetSimulator::Range& range, const ContactSet& rows) {
    if (stopped_) return;
    const auto start = std::chrono::steady_clock::now();
    spool_.append(number, rows);
    range.seconds.write = seconds_since(start);
    const std::lock_guard lock(mutex_);
    report_.contacts += range.count;
    report_.steps += range.steps;
    report_.kernel_seconds += range.kernel_seconds;
    report_.stages += range.seconds;
    report_.rows += rows.rows();
    ++written_;
    changed_.notify_all();
  }
  void fail(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    stopped_ = true;
    changed_.notify_all();
  }
  bool stopped() const { return stopped_; }

  /// Shows progress in the calling thread, and brings chunks to the disk, until all are written or someone stops.
  void watch() try {
    do {
      spool_.flush(std::chrono::seconds(5));
      if (options_.progress && !options_.progress(answered_, contacts_)) stopped_ = true;
    } while (!ended(std::chrono::milliseconds(100)));
  } catch (...) {
    fail(std::current_exception());
  }
  ProductionReport report() {
    if (error_) std::rethrow_exception(error_);
    report_.write_seconds = spool_.seconds();
    report_.finished = finished();
    if (!report_.finished) spool_.flush();  // else the set is made at once, and the chunks leave
    return report_;
  }

 private:
  bool finished() const { return written_ == chunks_.size(); }
  bool ended(std::chrono::milliseconds wait) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, wait, [&] { return stopped_ || finished(); });
  }

  const AnySource& source_;
  SetSpool& spool_;
  const ProductionOptions& options_;
  const std::vector<std::uint64_t>& chunks_;
  std::size_t contacts_ = 0;  ///< of the chunks
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t written_ = 0;                ///< chunks
  std::atomic<std::size_t> answered_ = 0;  ///< contacts
  std::exception_ptr error_;
  ProductionReport report_;
};

/// One device with its threads. Each takes a chunk through all stages, so that all are busy whichever stage is the
/// longest. One more than the device has: a thread waits while another's kernels run. Of a GPU the most: their launches
/// go side by side, and one alone leaves most of it idle.
class Line {
 public:
  Line(Production& production, const std::string& device, const SetOptions& options)
      : production_(production), executor_(Device(device)), simulator_(executor_, production.source(), options) {}
  ~Line() { threads_.clear(); }

  void start() {
    try {
      for (int i = 0; i < thread_count(); ++i)
        threads_.emplace_back([this] {
          try {
            produce();
          } catch (...) {
            production_.fail(std::current_exception());
          }
        });
    } catch (...) {  // a thread that could not be made: those that could go on
      if (threads_.empty()) production_.fail(std::current_exception());
    }
  }
  void wait() { threads_.clear(); }
  int thread_count() const {
    if (executor_.device().info().type == DeviceType::gpu) return most_threads;
    return std::min(std::max(executor_.threads(), 2) + 1, most_threads);
  }
  const std::string& device_name() const { return executor_.device().info().name; }

 private:
  void produce() try {
    const StopScope::Asked asked = [this] { return production_.stopped(); };
    const StopScope scope(&asked);
    while (const auto number = production_.next()) {
      const auto range = simulator_.prepare(*number * production_.chunk(), production_.contacts_of(*number));
      range->answered = production_.answered();
      if (production_.stopped()) return;
      simulator_.run(*range);
      if (production_.stopped()) return;
      production_.add(*number, *range, simulator_.collect(*range));
    }
  } catch (const Stopped&) {
    if (!production_.stopped()) throw;  // the compiler heard of it first
  }

  Production& production_;
  Executor executor_;
  SetSimulator simulator_;
  std::vector<std::jthread> threads_;
};

/// Chunks take the memory of those before them. One arena: a block that one thread gives back serves the others.
void keep_memory_of_chunks() {
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 1);
#endif
  keep_freed_memory(1 << 29);
}

}  // namespace

std::uint64_t chunk_count(const AnySource& source) {
  const std::uint64_t chunk = contacts_of_chunk(source);
  return (common(source).contacts() + chunk - 1) / chunk;
}

double expected_bytes(const AnySource& any, const SetColumns& columns) {
  const ContactSource& source = common(any);
  const std::uint64_t sample = std::min<std::uint64_t>(source.contacts(), 256), apart = source.contacts() / sample;
  std::size_t rows = 0;
  const auto add_rows = [&](std::size_t steps, std::size_t pressed) {
    rows += steps - (source.press_rows() ? 0 : pressed - 1);
  };
  for (std::uint64_t k = 0; k < sample; ++k) {
    if (const auto* lines = std::get_if<SceneSource>(&any)) {
      const fem::Scene scene = lines->contact(k * apart).scene;
      if (scene.friction == 0) continue;
      const fem::LoadPath path = fem::load_path(scene.load);
      const auto pressed = static_cast<std::size_t>(path.indentation_steps);
      add_rows(path.until_sliding ? pressed : path.steps.size(), pressed);
    } else {
      const auto& pads = std::get<PadSource>(any);
      const fem::PadScene scene = pads.contact(k * apart).scene;
      if (scene.friction == 0) continue;
      if (!pads.holds()) {
        add_rows(fem::pad_targets(scene.load).size(), fem::pressing_targets(scene.load));
        continue;
      }
      const Hold hold = pads.hold(k * apart);
      add_rows(hold.frames.size(), static_cast<std::size_t>(hold.pressing()));
    }
  }
  const std::size_t numbers = columns.has("parameters") ? columns.parameter_names.size() : 0;
  const double of_contact =
      static_cast<double>(rows) / static_cast<double>(sample) * static_cast<double>(row_bytes(columns)) +
      static_cast<double>(numbers * sizeof(float));
  return static_cast<double>(source.contacts()) * of_contact;
}

ProductionReport produce_set(const AnySource& source, SetSpool& spool, const std::vector<std::uint64_t>& chunks,
                             const ProductionOptions& options) {
  keep_memory_of_chunks();
  const auto start = std::chrono::steady_clock::now();
  Production production(source, spool, chunks, options);
  std::vector<std::unique_ptr<Line>> lines;
  for (const std::string& device : options.devices)
    lines.push_back(std::make_unique<Line>(production, device, options.set));
  for (auto& line : lines) line->start();
  production.watch();
  for (auto& line : lines) line->wait();
  ProductionReport report = production.report();
  report.seconds = seconds_since(start);
  for (auto& line : lines) report.devices.push_back(line->device_name());
  return report;
}

}  // namespace tactel::host
