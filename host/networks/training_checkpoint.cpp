// SPDX-License-Identifier: Apache-2.0
#include "host/networks/training_checkpoint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "host/support/bounded_file.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "kernels/shared/online_report.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view magic = "tactel checkpoint 5\n";

// File: magic, checksum of all that follows (8 bytes), then items, each with its number of bytes (8) before it: the
// plan; for each network its report, seconds and best error, counters, curve, weights, moments, mean and best weights
// (the last two may be empty). Byte order is the machine's.
class Writer {
 public:
  template <class T>
  void put(std::span<const T> values) {
    const std::uint64_t bytes = values.size_bytes();
    body_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    body_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  std::string content() const {
    const std::uint64_t sum = checksum(body_);
    return std::string(magic) + std::string(reinterpret_cast<const char*>(&sum), sizeof sum) + body_;
  }

 private:
  std::string body_;
};

class Reader {
 public:
  Reader(std::string_view content, std::string file) : rest_(content), file_(std::move(file)) {
    std::uint64_t sum = 0;
    if (!rest_.starts_with(magic))
      fail("not a checkpoint of a training, or of another version of tactel", "one of this version, or absent");
    rest_.remove_prefix(magic.size());
    if (rest_.size() < sizeof sum) fail("cut short", "whole");
    std::memcpy(&sum, rest_.data(), sizeof sum);
    rest_.remove_prefix(sizeof sum);
    if (checksum(rest_) != sum) damaged();
  }
  void expect_plan(std::string_view plan) {
    const std::vector<char> its_plan = take<char>();
    if (std::string_view(its_plan.data(), its_plan.size()) != plan)
      fail("of another training",
           "of this one (same set, networks, seeds, noise, options, precision and device lanes), or absent");
  }
  void expect_end() const {
    if (!rest_.empty()) damaged();
  }
  [[noreturn]] void damaged() const { fail("damaged", "whole; delete it to start anew"); }
  template <class T>
  std::vector<T> take() {
    std::uint64_t bytes = 0;
    if (rest_.size() >= sizeof bytes) std::memcpy(&bytes, rest_.data(), sizeof bytes);
    if (rest_.size() < sizeof bytes || bytes > rest_.size() - sizeof bytes || bytes % sizeof(T) != 0)
      fail("cut short", "whole");
    std::vector<T> values(bytes / sizeof(T));
    if (bytes > 0) std::memcpy(values.data(), rest_.data() + sizeof bytes, bytes);
    rest_.remove_prefix(sizeof bytes + bytes);
    return values;
  }
  [[noreturn]] void fail(const char* what, const char* allowed) const {
    throw ConfigError(file_, "checkpoint", what, allowed);
  }

 private:
  std::string_view rest_;
  std::string file_;
};

// A network's report and curve in a file, at most: a curve has some 230 points on its way to 2^32 cycles.
constexpr std::uintmax_t bytes_of_a_network = 64 << 10;
constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 36;  ///< of a file of which only the plan is read

// None where there is no such file.
std::optional<std::string> content_of(const fs::path& path, std::uintmax_t most) try {
  return read_bounded_file(path, most);
} catch (const UnreadableFile& error) {
  if (error.missing) return std::nullopt;
  throw ConfigError(path.string(), "checkpoint", std::string("cannot be read (") + error.what() + ")",
                    "one of this training, or absent");
}

/// Whether the cycles of a curve rise.
bool rising(const std::vector<CurvePoint>& curve) {
  return std::ranges::adjacent_find(curve, std::greater_equal(), &CurvePoint::cycle) == curve.end();
}

template <class Real>
void read_record(Reader& reader, NetworkRecord<Real>& record) {
  TrainedNetwork& network = record.network;
  nn::BatchState<Real>& state = record.state;
  const std::vector<OnlineReport> report = reader.take<OnlineReport>();
  const std::vector<double> seconds = reader.take<double>();
  const std::vector<std::uint64_t> counters = reader.take<std::uint64_t>();
  network.curve = reader.take<CurvePoint>();
  if (report.size() != 1 || seconds.size() != 2 || counters.size() != 4 || !rising(network.curve)) reader.damaged();
  for (auto* numbers : {&state.weights, &state.first, &state.second}) {
    const std::size_t expected = numbers->values.size();
    numbers->values = reader.take<Real>();
    if (numbers->values.size() != expected) reader.damaged();
  }
  for (std::vector<Real>* numbers : {&state.mean.values, &record.best}) {
    *numbers = reader.take<Real>();
    if (!numbers->empty() && numbers->size() != state.weights.values.size()) reader.damaged();
  }
  const bool known = report[0].status >= ONLINE_RUNNING && report[0].status <= int(nn::TrainStatus::early_stop);
  if (!known || !(seconds[0] >= 0) || !std::isfinite(seconds[0]) || !(seconds[1] >= 0) ||
      std::max(counters[2], counters[3]) > std::numeric_limits<std::uint32_t>::max())
    reader.damaged();
  network.seconds = seconds[0];
  network.best_error = seconds[1];
  network.rows = state.rows = counters[0];
  state.updates = counters[1];
  state.epoch = static_cast<std::uint32_t>(counters[2]);
  network.best_cycle = static_cast<std::uint32_t>(counters[3]);
  network.status = static_cast<nn::TrainStatus>(report[0].status);
  network.cycles = report[0].cycle;
  network.sse = report[0].sse;
  network.largest = report[0].largest;
}

}  // namespace

template <class Real>
void write_checkpoint(const fs::path& path, const std::string& plan, std::span<const NetworkRecord<Real>> records) {
  Writer writer;
  writer.put(std::span<const char>(plan));
  for (const NetworkRecord<Real>& record : records) {
    const TrainedNetwork& network = record.network;
    const nn::BatchState<Real>& state = record.state;
    const OnlineReport report{static_cast<std::int32_t>(network.status), network.cycles, network.sse, network.largest};
    writer.put(std::span<const OnlineReport>(&report, 1));
    writer.put(std::span<const double>(std::array{network.seconds, network.best_error}));
    writer.put(std::span<const std::uint64_t>(
        std::array{network.rows, state.updates, std::uint64_t{state.epoch}, std::uint64_t{network.best_cycle}}));
    writer.put(std::span<const CurvePoint>(network.curve));
    for (const auto* numbers :
         {&state.weights.values, &state.first.values, &state.second.values, &state.mean.values, &record.best})
      writer.put(std::span<const Real>(*numbers));
  }
  write_file("--output", path, writer.content());
}

void expect_checkpoint_of(const fs::path& path, const std::string& plan) {
  if (const auto content = content_of(path, most_bytes)) Reader(*content, path.string()).expect_plan(plan);
}

template <class Real>
bool read_checkpoint(const fs::path& path, const std::string& plan, std::span<NetworkRecord<Real>> records) {
  std::uintmax_t most = magic.size() + plan.size() + bytes_of_a_network;
  for (const NetworkRecord<Real>& record : records)
    most += bytes_of_a_network + 5 * sizeof(Real) * record.state.weights.values.size();
  const auto content = content_of(path, most);
  if (!content) return false;
  Reader reader(*content, path.string());
  reader.expect_plan(plan);
  for (NetworkRecord<Real>& record : records) read_record(reader, record);
  reader.expect_end();
  return true;
}

template void write_checkpoint(const fs::path&, const std::string&, std::span<const NetworkRecord<float>>);
template void write_checkpoint(const fs::path&, const std::string&, std::span<const NetworkRecord<double>>);
template bool read_checkpoint(const fs::path&, const std::string&, std::span<NetworkRecord<float>>);
template bool read_checkpoint(const fs::path&, const std::string&, std::span<NetworkRecord<double>>);

}  // namespace tactel::host
