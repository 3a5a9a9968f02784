#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <fstream>

#include "host/atomic_file.h"
#include "host/command.h"
#include "host/errors.h"
#include "host/interrupt.h"
#include "host/open_source.h"
#include "hw/decoder.h"
#include "hw/recording.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double longest_wait = 0.05;  // s: how soon Ctrl-C is noticed

struct RecordRequest {
  std::string source, profile, calibration, output, frames;
  double seconds = 0;
  bool quiet = false;
};

/// Whether it is time to end.
class Until {
 public:
  explicit Until(double seconds) : seconds_(seconds) {}
  bool operator()() const { return interrupt_.requested() || (seconds_ > 0 && passed() >= seconds_); }
  bool by_signal() const { return interrupt_.requested(); }
  double passed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  double seconds_;
  Interrupt interrupt_;
  Clock::time_point start_ = Clock::now();
};

/// Decoded frames as they come, one a line: number, device time, arrival, and the values in the device's units.
class FrameTable {
 public:
  FrameTable(const std::string& path, std::size_t channels) {
    if (path.empty()) return;
    check_writable("--frames", path);
    file_.open(path);
    file_ << "frame,device_time,arrival";
    for (std::size_t i = 0; i < channels; ++i) file_ << ",channel" << i;
    file_ << '\n';
  }
  void add(const hw::DecodedFrame& frame, double arrival) {
    if (!file_.is_open()) return;
    file_ << number_++ << ',' << (frame.device_time ? fmt::format("{}", *frame.device_time) : "") << ','
          << fmt::format("{}", arrival);
    for (const double value : frame.values) file_ << ',' << fmt::format("{}", value);
    file_ << '\n';
  }

 private:
  std::ofstream file_;
  std::uint64_t number_ = 0;
};

using Take = std::function<void(const hw::Packet&)>;

void for_each_packet(hw::FrameSource& source, const Until& end, const Take& take) {
  while (!source.finished() && !end())
    if (const auto packet = source.wait(longest_wait)) take(*packet);
}

void print_counts(const hw::DecoderCounts& counts, const hw::TransportCounts& transport, double seconds) {
  fmt::print(stderr, "{} frames in {:.1f} s, {} bytes; lost {}, bad {}, resynchronised {}, overruns {}\n",
             counts.frames, seconds, transport.bytes, counts.lost, counts.bad, counts.resynchronised,
             transport.overruns);
}

int run_record(const RecordRequest& request) {
  check_writable("--output", request.output);
  OpenSource opened = open_source(request.source, request.profile, request.calibration);
  hw::Decoder decoder(opened.profile.format());
  FrameTable table(request.frames, decoder.format().channels());
  hw::RecordingWriter writer(request.output, opened.profile.text);
  const Until end(request.seconds);
  for_each_packet(*opened.source, end, [&](const hw::Packet& packet) {
    writer.write(packet, decoder.counts().frames);
    if (packet.after_gap) decoder.interrupt();
    decoder.feed(packet.bytes, [&](const hw::DecodedFrame& frame) { table.add(frame, packet.arrival); });
  });
  writer.finish();
  if (!request.quiet) print_counts(decoder.counts(), opened.source->counts(), end.passed());
  return end.by_signal() ? static_cast<int>(interrupted) : done;
}

struct TareRequest {
  std::string source, profile, calibration, output;
  double seconds = 2;
};

int run_tare(const TareRequest& request) {
  check_writable("--output", request.output);
  OpenSource opened = open_source(request.source, request.profile, request.calibration);
  hw::Decoder decoder(opened.profile.format());
  hw::Tare tare(decoder.format().channels());
  const Until end(request.seconds);
  for_each_packet(*opened.source, end, [&](const hw::Packet& packet) {
    decoder.feed(packet.bytes, [&](const hw::DecodedFrame& frame) { tare.add(frame.values); });
  });
  if (tare.frames() == 0) throw hw::SourceError("no frame came within " + fmt::format("{} s", request.seconds));
  hw::Calibration calibration = opened.profile.map.calibration;
  calibration.offset = tare.offset();
  write_file("--output", request.output, calibration_text(calibration));
  fmt::print(stderr, "the mean of {} frames at rest is in {}\n", tare.frames(), request.output);
  return done;
}

}  // namespace

void add_source_options(CLI::App& command, std::string& source, std::string& profile, std::string& calibration) {
  command
      .add_option("--source", source,
                  "usb:glove, usb:VID:PID, replay:FILE or simulate:SCENE.toml?rate=100 (docs/sensors.md)")
      ->type_name("SOURCE")
      ->required();
  command.add_option("--profile", profile, "device profile: wire format and channels")->type_name("FILE.toml");
  command.add_option("--calibration", calibration, "offsets and gains in the place of the profile's, see tactel tare")
      ->type_name("FILE.toml");
}

void add_record_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<RecordRequest>();
  CLI::App* command = app.add_subcommand("record", "raw bytes of a sensor with their arrival times, to be replayed");
  add_source_options(*command, request->source, request->profile, request->calibration);
  command->add_option("--output", request->output, "the recording, for --source replay:FILE")
      ->type_name("FILE")
      ->required();
  command->add_option("--frames", request->frames, "write the decoded frames, too, as CSV")->type_name("FILE.csv");
  command
      ->add_option("--seconds", request->seconds, "stop after so many s (default: at the end of the source, or Ctrl-C)")
      ->check(CLI::PositiveNumber);
  command->add_flag("--quiet", request->quiet, "no summary on stderr");
  command->callback([request, &action] { action = [request] { return run_record(*request); }; });
}

void add_tare_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<TareRequest>();
  CLI::App* command = app.add_subcommand("tare", "offsets of a sensor at rest, as a calibration file");
  add_source_options(*command, request->source, request->profile, request->calibration);
  command->add_option("--output", request->output, "the calibration, for --calibration")
      ->type_name("FILE.toml")
      ->required();
  command->add_option("--seconds", request->seconds, "how long to listen, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->callback([request, &action] { action = [request] { return run_tare(*request); }; });
}

}  // namespace tactel::host
