#include "host/sweep_checkpoint.h"

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>

#include "host/checksum.h"
#include "host/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view magic = "tactel checkpoint 2\n";

// File: magic, checksum of all that follows (8 bytes), then items, each with its number of bytes (8) before it: the
// plan; for each network its report, seconds, curve, weights, moments. Byte order is the machine's.
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
    if (!rest_.starts_with(magic)) fail("not a checkpoint of a training", "a checkpoint");
    rest_.remove_prefix(magic.size());
    if (rest_.size() < sizeof sum) fail("cut short", "whole");
    std::memcpy(&sum, rest_.data(), sizeof sum);
    rest_.remove_prefix(sizeof sum);
    if (checksum(rest_) != sum) fail("damaged", "whole; delete it to start anew");
  }
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

void write_file(const fs::path& path, const std::string& content) {
  const fs::path temporary = path.string() + ".part";
  {
    std::ofstream file(temporary, std::ios::binary);
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    file.close();
    if (!file)
      throw ConfigError(path.string(), "checkpoint", "cannot be written", "in a directory that can be written to");
  }
  fs::rename(temporary, path);
}

}  // namespace

template <class Real>
void write_checkpoint(const fs::path& path, const std::string& plan, std::span<const NetworkRecord<Real>> records) {
  Writer writer;
  writer.put(std::span<const char>(plan));
  for (const NetworkRecord<Real>& record : records) {
    const SweepNetwork& network = record.network;
    const OnlineReport report{static_cast<std::int32_t>(network.status), network.cycles, network.sse, network.largest};
    writer.put(std::span<const OnlineReport>(&report, 1));
    writer.put(std::span<const double>(&network.seconds, 1));
    writer.put(std::span<const std::uint64_t>(std::array{record.rows, record.updates}));
    writer.put(std::span<const std::uint32_t>(network.curve.cycle));
    writer.put(std::span<const float>(network.curve.sse));
    writer.put(std::span<const float>(network.curve.largest));
    for (const auto* numbers : {&record.weights, &record.first, &record.second})
      writer.put(std::span<const Real>(*numbers));
  }
  write_file(path, writer.content());
}

template <class Real>
bool read_checkpoint(const fs::path& path, const std::string& plan, std::span<NetworkRecord<Real>> records) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  const std::string content(std::istreambuf_iterator<char>(file), {});
  Reader reader(content, path.string());
  const std::vector<char> its_plan = reader.take<char>();
  if (std::string_view(its_plan.data(), its_plan.size()) != plan)
    reader.fail("of another training",
                "of this one (same set, networks, seeds, noise, options, precision and device lanes), or absent");
  for (NetworkRecord<Real>& record : records) {
    SweepNetwork& network = record.network;
    const std::vector<OnlineReport> report = reader.take<OnlineReport>();
    const std::vector<double> seconds = reader.take<double>();
    const std::vector<std::uint64_t> counters = reader.take<std::uint64_t>();
    network.curve.cycle = reader.take<std::uint32_t>();
    network.curve.sse = reader.take<float>();
    network.curve.largest = reader.take<float>();
    const std::size_t points = network.curve.cycle.size();
    bool fits = report.size() == 1 && seconds.size() == 1 && counters.size() == 2 &&
                network.curve.sse.size() == points && network.curve.largest.size() == points;
    for (auto* numbers : {&record.weights, &record.first, &record.second}) {
      const std::size_t expected = numbers->size();
      *numbers = reader.take<Real>();
      fits = fits && numbers->size() == expected;
    }
    if (!fits) reader.fail("damaged", "whole; delete it to start anew");
    network.seconds = seconds[0];
    record.rows = counters[0];
    record.updates = counters[1];
    network.status = static_cast<nn::TrainStatus>(report[0].status);
    network.cycles = report[0].cycle;
    network.sse = report[0].sse;
    network.largest = report[0].largest;
  }
  return true;
}

template void write_checkpoint(const fs::path&, const std::string&, std::span<const NetworkRecord<float>>);
template void write_checkpoint(const fs::path&, const std::string&, std::span<const NetworkRecord<double>>);
template bool read_checkpoint(const fs::path&, const std::string&, std::span<NetworkRecord<float>>);
template bool read_checkpoint(const fs::path&, const std::string&, std::span<NetworkRecord<double>>);

}  // namespace tactel::host
