// SPDX-License-Identifier: Apache-2.0
#include "hw/recording.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <string_view>

#include "hw/format_parts.h"

namespace tactel::hw {
namespace {

constexpr std::string_view magic = recording_magic;
constexpr std::uint8_t description_record = 'D', packet_record = 'P', end_record = 'I';
constexpr std::size_t record_head = 1 + 4, record_tail = 4;  // kind, length of the body; CRC-32 of both
constexpr std::size_t packet_head = 8 + 1;                   // arrival, flags
constexpr std::size_t largest_body = 1 << 24;                // bytes
constexpr double latest_arrival = 1e9;  // s, 30 years: no clock that starts with its source shows more

void put_number(std::vector<std::uint8_t>& bytes, std::uint64_t value, int width) {
  for (int i = 0; i < width; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

/// A record around a body that `fill` appends.
template <class Fill>
void make_record(std::vector<std::uint8_t>& record, std::uint8_t kind, std::size_t length, const Fill& fill) {
  record.clear();
  record.push_back(kind);
  put_number(record, length, 4);
  fill(record);
  put_number(record, crc32(record), 4);
}

void put_bytes(std::vector<std::uint8_t>& record, Bytes bytes) { std::ranges::copy(bytes, std::back_inserter(record)); }

}  // namespace

std::uint32_t crc32(Bytes bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> remainders{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      remainders[i] = i;
      for (int bit = 0; bit < 8; ++bit) remainders[i] = remainders[i] >> 1 ^ (remainders[i] & 1 ? 0xEDB88320u : 0u);
    }
    return remainders;
  }();
  std::uint32_t crc = ~0u;
  for (const std::uint8_t byte : bytes) crc = table[(crc ^ byte) & 0xFF] ^ crc >> 8;
  return ~crc;
}

RecordingWriter::RecordingWriter(const std::filesystem::path& path, const std::string& description,
                                 OutputFile::Existing existing)
    : file_(path, existing) {
  if (description.size() > largest_body) throw RecordingError(path.string() + ": its profile is larger than 16 MiB");
  file_.write(magic);
  const Bytes text(reinterpret_cast<const std::uint8_t*>(description.data()), description.size());
  make_record(record_, description_record, description.size(), [&](auto& record) { put_bytes(record, text); });
  file_.write(Bytes(record_));
  file_.flush();
}

void RecordingWriter::write(const Packet& packet) {
  make_record(record_, packet_record, packet_head + packet.bytes.size(), [&](auto& record) {
    put_number(record, std::bit_cast<std::uint64_t>(packet.arrival), 8);
    record.push_back(packet.after_gap ? 1 : 0);
    put_bytes(record, packet.bytes);
  });
  file_.write(Bytes(record_));
}

void RecordingWriter::finish() {
  make_record(record_, end_record, 8, [&](auto& record) { put_number(record, file_.size(), 8); });
  file_.write(Bytes(record_));
  file_.close();
}

struct ReplaySource::State {
  std::string path, description;
  std::ifstream file;
  bool finished = false, cut_short = false;
  std::vector<std::uint8_t> record;
  Pace pace;
  bool held = false;  ///< the record in hand waits for its time
  TransportCounts counts;

  [[noreturn]] void fail(const std::string& what) const { throw RecordingError(path + ": " + what); }
  [[noreturn]] void refuse(const std::string& what) const { fail(what + "; must be a file that tactel record wrote"); }

  /// Reads the head of a record; false at the end of the file, and where the file was cut off.
  bool read_head() {
    record.resize(record_head);
    return read_into(0, record_head);
  }
  std::size_t length() const { return unsigned_at(record, 1, 4); }

  /// Reads the rest of a record after its head.
  bool read_body() {
    const std::size_t end = record_head + length();
    if (length() > largest_body) fail("damaged: a record of " + std::to_string(length()) + " bytes");
    record.resize(end + record_tail);
    if (!read_into(record_head, length() + record_tail)) return false;
    if (crc32(Bytes(record).first(end)) != unsigned_at(record, end, 4)) fail("damaged: a checksum does not match");
    return true;
  }

  bool read_into(std::size_t at, std::size_t count) {
    file.read(reinterpret_cast<char*>(record.data() + at), static_cast<std::streamsize>(count));
    if (file.bad()) fail("cannot be read: " + std::string(std::strerror(errno)));
    return file.gcount() == static_cast<std::streamsize>(count);
  }

  Bytes body() const { return Bytes(record).subspan(record_head, record.size() - record_head - record_tail); }

  void open(const std::filesystem::path& from) {
    path = from.string();
    std::error_code error;
    if (std::filesystem::exists(from, error) && !std::filesystem::is_regular_file(from, error))
      refuse("no regular file");  // a pipe could wait for ever
    file.open(from, std::ios::binary);
    if (!file) refuse("cannot be read: " + std::string(std::strerror(errno)));
    record.resize(magic.size());
    if (!read_into(0, magic.size()) || std::memcmp(record.data(), magic.data(), magic.size()) != 0)
      refuse("not a recording of tactel");
    if (!read_head() || record[0] != description_record || !read_body())
      fail("damaged: no description at its beginning");
    description.assign(body().begin(), body().end());
  }

  /// The next packet into `record`; false at the end.
  bool next() {
    if (finished) return false;
    if (read_head()) {
      if (record[0] != packet_record && record[0] != end_record) fail("damaged: an unknown record");
      if (read_body()) return record[0] == packet_record ? check_packet() : !(finished = true);
    }
    cut_short = finished = true;
    return false;
  }

  bool check_packet() const {
    if (length() < packet_head) fail("damaged: a packet without a head");
    if (!(arrival() >= 0 && arrival() <= latest_arrival)) fail("damaged: a packet whose arrival is no time");
    return true;
  }

  double arrival() const { return std::bit_cast<double>(unsigned_at(body(), 0, 8)); }
};

ReplaySource::ReplaySource(const std::filesystem::path& path, bool real_time) : state_(std::make_unique<State>()) {
  state_->open(path);
  state_->pace = Pace(real_time);
}
ReplaySource::~ReplaySource() = default;

const std::string& ReplaySource::description() const { return state_->description; }
bool ReplaySource::cut_short() const { return state_->cut_short; }
bool ReplaySource::finished() const { return state_->finished; }
TransportCounts ReplaySource::counts() const { return state_->counts; }

double ReplaySource::now() const { return state_->pace.now(); }

std::optional<Packet> ReplaySource::wait(double timeout) {
  State& s = *state_;
  if (!s.held && !s.next()) return std::nullopt;
  s.held = !s.pace.due(s.arrival(), timeout);
  if (s.held) return std::nullopt;
  const Bytes bytes = s.body().subspan(packet_head);
  ++s.counts.packets;
  s.counts.bytes += bytes.size();
  s.pace.hand_out(s.arrival());
  return Packet{bytes, s.arrival(), s.body()[8] != 0};
}

}  // namespace tactel::hw
