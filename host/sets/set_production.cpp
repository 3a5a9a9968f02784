// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_production.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <thread>

#include "host/support/bounded_queue.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Chunk {
  std::uint64_t number = 0;
  std::unique_ptr<SetSimulator::Range> range;
};

/// What the devices share: which chunk is next, the spool, and whether to stop.
class Production {
 public:
  Production(const SceneSource& source, SetSpool& spool, const ProductionOptions& options)
      : source_(source), spool_(spool), options_(options) {
    const std::set<std::uint64_t> there = spool.chunks();
    for (std::uint64_t chunk = 0; chunk < chunk_count(source); ++chunk)
      if (chunk % options.ranks == static_cast<std::uint64_t>(options.rank) && !there.contains(chunk))
        missing_.push_back(chunk);
  }

  const SceneSource& source() const { return source_; }
  std::optional<std::uint64_t> next() {
    const std::size_t i = next_++;
    return stopped_ || i >= missing_.size() ? std::nullopt : std::optional(missing_[i]);
  }
  void add(const Chunk& chunk, const ContactSet& rows) {
    const std::lock_guard lock(mutex_);
    if (stopped_) return;
    const auto start = Clock::now();
    spool_.append(chunk.number, rows);
    report_.write_seconds += seconds_since(start);
    report_.contacts += chunk.range->count;
    report_.steps += chunk.range->steps;
    report_.kernel_seconds += chunk.range->kernel_seconds;
    report_.rows += rows.rows();
    ++done_;
    changed_.notify_all();
  }
  void fail(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    stopped_ = true;
    changed_.notify_all();
  }
  bool stopped() const { return stopped_; }

  /// Shows progress in the calling thread until everything is done, or someone stops.
  void watch() {
    std::unique_lock lock(mutex_);
    while (!stopped_ && done_ < missing_.size()) {
      try {
        if (options_.progress && !options_.progress(done_, missing_.size())) stopped_ = true;
      } catch (...) {
        if (!error_) error_ = std::current_exception();
        stopped_ = true;
      }
      changed_.wait_for(lock, std::chrono::milliseconds(100));
    }
  }
  ProductionReport report() {
    if (error_) std::rethrow_exception(error_);
    report_.finished = done_ == missing_.size();
    return report_;
  }

 private:
  const SceneSource& source_;
  SetSpool& spool_;
  const ProductionOptions& options_;
  std::vector<std::uint64_t> missing_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t done_ = 0;
  std::exception_ptr error_;
  ProductionReport report_;
};

/// One device with its three threads.
class Line {
 public:
  Line(Production& production, const std::string& device, const SetOptions& options)
      : production_(production), executor_(Device(device)), simulator_(executor_, production.source(), options) {}
  ~Line() { threads_.clear(); }

  void start() {
    // A stage that ends, for whatever reason, lets the one before it and the one after it end, too.
    const auto thread = [&](auto stage, BoundedQueue<Chunk>* before, BoundedQueue<Chunk>* after) {
      threads_.emplace_back([this, stage, before, after] {
        try {
          (this->*stage)();
        } catch (...) {
          production_.fail(std::current_exception());
        }
        if (before) before->close(true);
        if (after) after->close();
      });
    };
    try {
      thread(&Line::draw, nullptr, &drawn_);
      thread(&Line::solve, &drawn_, &solved_);
      thread(&Line::gather, &solved_, nullptr);
    } catch (...) {  // a thread that could not be made: the others must not wait for it
      production_.fail(std::current_exception());
      drawn_.close(true), solved_.close(true);
    }
  }
  void wait() { threads_.clear(); }
  const std::string& device_name() const { return executor_.device().info().name; }

 private:
  void draw() {
    while (const auto number = production_.next()) {
      const std::uint64_t first = *number * chunk_contacts;
      const std::uint64_t count = std::min(chunk_contacts, production_.source().contacts() - first);
      if (!drawn_.push({*number, simulator_.prepare(first, count)})) return;
    }
  }
  void solve() {
    while (auto chunk = drawn_.pop()) {
      if (production_.stopped()) return;
      simulator_.run(*chunk->range);
      if (!solved_.push(std::move(*chunk))) return;
    }
  }
  void gather() {
    while (auto chunk = solved_.pop()) {
      if (production_.stopped()) return;
      production_.add(*chunk, simulator_.collect(*chunk->range));
    }
  }

  Production& production_;
  Executor executor_;
  SetSimulator simulator_;
  BoundedQueue<Chunk> drawn_{1}, solved_{1};
  std::vector<std::jthread> threads_;
};

}  // namespace

std::uint64_t chunk_count(const SceneSource& source) {
  return (source.contacts() + chunk_contacts - 1) / chunk_contacts;
}

ProductionReport produce_set(const SceneSource& source, SetSpool& spool, const ProductionOptions& options) {
  const auto start = Clock::now();
  Production production(source, spool, options);
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
