// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/live/sensor_session.h"
#include "host/live/frame_reader.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/progress_line.h"
#include "hw/recording.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

struct RecordRequest : SensorRequest {
  std::string output, frames;
  bool force = false;
  hw::OutputFile::Existing existing() const {
    return force ? hw::OutputFile::Existing::replace : hw::OutputFile::Existing::refuse;
  }
};

/// Decoded frames as they come, one a line: number, device time, arrival, and the values in the device's units.
class FrameTable {
 public:
  FrameTable(const RecordRequest& request, std::size_t channels) {
    if (request.frames.empty()) return;
    file_.emplace(request.frames, request.existing());
    std::string head = "frame,device_time,arrival";
    for (std::size_t i = 0; i < channels; ++i) head += fmt::format(",channel{}", i);
    file_->write(head + "\n");
  }
  void add(const hw::DecodedFrame& frame, double arrival) {
    if (!file_) return;
    std::string line =
        fmt::format("{},{},{}", number_++, frame.device_time ? fmt::format("{}", *frame.device_time) : "", arrival);
    for (const double value : frame.values) line += fmt::format(",{}", value);
    file_->write(line + "\n");
  }
  void finish() {
    if (file_) file_->close();
  }

 private:
  std::optional<hw::OutputFile> file_;
  std::uint64_t number_ = 0;
};

void check_output(const RecordRequest& request, const std::string& option, const std::string& path) {
  if (path.empty()) return;
  check_writable(option, path);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const bool stream = fs::is_character_file(status) || fs::is_fifo(status);
  if (!request.force && !stream && fs::symlink_status(path, error).type() != fs::file_type::not_found)
    throw ConfigError("command line", option, path, "a new file, or --force to overwrite it");
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return !a.empty() && !b.empty() && (a == b || fs::equivalent(a, b, error));
}

/// --force is no leave to write over the file that is read, or to put two things into one file.
void check_outputs(const RecordRequest& request) {
  check_output(request, "--output", request.output);
  check_output(request, "--frames", request.frames);
  if (same_file(request.output, request.frames))
    throw ConfigError("command line", "--frames", request.frames, "another file than --output");
  const std::size_t kind = request.source.find(':') + 1;
  if (!request.source.starts_with("replay:") && !request.source.starts_with("csv:")) return;
  const std::string read = request.source.substr(kind, request.source.find('?') - kind);
  for (const auto& [option, path] : {std::pair{"--output", request.output}, {"--frames", request.frames}})
    if (same_file(read, path))
      throw ConfigError("command line", option, path, "another file than the one that is read");
}

void print_counts(const hw::DecoderCounts& counts, const hw::TransportCounts& transport, double seconds) {
  say(fmt::format("{} frames in {:.1f} s, {} bytes; lost {}, bad {}, resynchronised {}, overruns {}", counts.frames,
                  seconds, transport.bytes, counts.lost, counts.bad + transport.bad, counts.resynchronised,
                  transport.overruns));
}

/// Reads into both files. The recording gets its end also where the source or the table fails: its packets are whole.
void read_into(hw::RecordingWriter& writer, FrameTable& table, hw::FrameSource& source, hw::Decoder& decoder,
               const Until& until) {
  try {
    read_frames(source, decoder,
                {.packet = [&](const hw::Packet& packet) { writer.write(packet); },
                 .frame = [&](const hw::DecodedFrame& frame, double arrival) { table.add(frame, arrival); },
                 .stop = [&] { return until(); }});
    table.finish();
  } catch (const std::exception&) {
    try {
      writer.finish();
    } catch (const hw::RecordingError&) {  // the first failure is the one to be told
    }
    throw;
  }
  writer.finish();
}

int run_record(const RecordRequest& request) {
  check_outputs(request);
  OpenSource opened = open_for(request);
  hw::Decoder decoder(opened.profile.format());
  const Until until(*opened.source, request.seconds);
  FrameTable table(request, decoder.format().channels());
  hw::RecordingWriter writer(request.output, opened.profile.text, request.existing());
  {
    const StageLine stage("recording to " + request.output, request.quiet);
    read_into(writer, table, *opened.source, decoder, until);
  }
  say_if_cut_short(request, *opened.source);
  say_if_nothing_decoded(request, *opened.source, decoder.counts());
  if (!request.quiet) print_counts(decoder.counts(), opened.source->counts(), until.passed());
  return until.by_signal() ? static_cast<int>(interrupted) : done;
}

}  // namespace

void add_record_command(CLI::App& app, Action& action) {
  const auto [command, request] =
      add_command(app, action, "Read a sensor", "record",
                  "record the raw bytes of a sensor with their arrival times, for replay", run_record);
  add_sensor_options(command, request);
  add_option(command, "--output", request.output, "the recording, for --source replay:FILE", {.type = "FILE"})
      ->required();
  add_option(command, "--frames", request.frames, "also write the decoded frames as CSV", {.type = "FILE.csv"});
  add_option(command, "--force", request.force, "overwrite --output and --frames where they exist");
  add_option(command, "--seconds", request.seconds,
             "stop after this time, s (default: at the end of the source, or Ctrl-C)")
      ->check(positive_number());
  add_option(command, "--quiet", request.quiet, "no summary and no warnings on stderr");
}

}  // namespace tactel::host
