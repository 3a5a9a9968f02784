// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "host/commands/live/monitor_request.h"

namespace tactel::host {

void add_monitor_options(CLI::App& command, MonitorRequest& request) {
  add_sensor_options(command, request);
  command
      .add_option("--network", request.networks,
                  "network that evaluates the frames, see tactel train; of several pads once, or once for each; "
                  "needed but with --rest")
      ->type_name("FILE.onnx")
      ->allow_extra_args(false);
  command.add_option("--every", request.every, "print only every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option("--seconds", request.seconds,
                  "stop after this time, s (default: at the end of the source, or Ctrl-C)")
      ->check(positive_number());
  command.add_option("--late", request.options.late, "drop and count live frames older than this, s")
      ->check(positive_number())
      ->capture_default_str();
  command
      .add_option("--touch", request.options.touch,
                  "a frame whose normal stresses all stay below this is no contact: its S is null, and it ends an "
                  "alarm; 0: every frame is a contact, MPa (default: 7 standard deviations of the noise in the "
                  "calibration, see tactel tare, and at least the smallest peak that the network learnt)")
      ->check(not_negative_number());
  command
      .add_option("--drift", request.options.drift,
                  "compare this long at rest with offsets and noise of the calibration, and say which channels no "
                  "longer fit; twice the time constant of charge amplifiers, or more; 0: never, s")
      ->check(not_negative_number())
      ->capture_default_str();
  command.add_flag(
      "--view", request.view,
      "a picture instead of lines: S and its history, the tactels' stresses as blocks, shear with its direction; of "
      "pads a tile a tactel, shaded by pressure, with an arrow of shear");
  CLI::Option* serve =
      command
          .add_option(
              "--serve", request.serve,
              "a page for browsers beside the lines: pads or the line, what the alarm judges over ten seconds, and "
              "the truth of a simulation; PORT of this machine alone, or ADDRESS:PORT, 0.0.0.0:8080 for a telephone "
              "beside the gripper; port 0: any (default: 8080)")
          ->type_name("PLACE")
          ->expected(0, 1);
  command
      .add_option("--serve-host", request.serve_hosts,
                  "a name of this machine by which browsers may ask for the page, beside localhost and addresses; "
                  "repeatable")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->needs(serve);
  command.add_flag("--stresses", request.stresses, "add \"stresses\" to each line: all tactels, axis by axis, MPa");
  CLI::Option* alarm =
      command
          .add_option(
              "--alarm", request.alarm_given,
              "add \"alarm\" to each line: true from this upper bound of S on (S itself where the network has no "
              "bound), false again 0.05 below; a line where it changes is always printed; --view shows it, too; with "
              "--signal moved from this \"moved\" on, with a network of slid from this answer on, no unit (default: "
              "0.8; of moved that of tactel tare --hold; of slid that or the network's own)")
          ->type_name("FLOAT")
          ->expected(0, 1)
          ->check(CLI::Range(0.0f, 1.0f));
  command.add_flag(
      "--rest", request.options.rest,
      "add \"rest\", whether a rest of the grip is known, and \"moved\", the change of all stresses since, "
      "over the normal force then; a line \"rest\" on standard input seeks rest anew");
  command
      .add_option("--signal", request.signal,
                  "what --alarm acts on: slip, S or its bound, or moved, with --rest (default: slip, without a network "
                  "moved)")
      ->check(CLI::IsMember({"slip", "moved"}));
  CLI::Option* friction = command
                              .add_option("--friction", request.options.friction,
                                          "mu, as far as it is known, for networks of train --friction; while an "
                                          "object slides, a line \"slides\" on standard input has it read")
                              ->type_name("MU")
                              ->check(CLI::Range(1e-3, 1e3));
  command.add_option("--friction-spread", request.options.friction_spread, "relative standard deviation of that mu")
      ->type_name("FLOAT")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str()
      ->needs(friction);
  command
      .add_option("--friction-drift", request.options.friction_drift,
                  "relative standard deviation by which mu, as read from a slide, drifts in the next minute; it is "
                  "trusted less with the root of time")
      ->type_name("FLOAT")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str();
  command
      .add_option("--hold", request.options.hold,
                  "with --alarm: it begins at the last of so many frames in a row that ask for it")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str()
      ->needs(alarm);
  command
      .add_option("--unlike", request.unlike,
                  "with --alarm: what a frame does that is unlike those learnt, of which the network cannot tell S: "
                  "alarm, or ignore: the alarm goes by S")
      ->check(CLI::IsMember({"alarm", "ignore"}))
      ->capture_default_str()
      ->needs(alarm);
  command
      .add_option("--widest", request.widest,
                  "with --alarm: no alarm begins at a frame with a wider interval of S, which is then "
                  "\"cannot_tell\", no unit")
      ->type_name("FLOAT")
      ->check(CLI::Range(0.0f, 2.0f))
      ->needs(alarm)
      ->excludes("--view");
  command
      .add_option("--device", request.device,
                  "OpenCL device that evaluates the networks, all pads by one launch; gpu, cpu, or as of "
                  "`tactel devices` (default: host code, with the same bits, quicker for a sensor or two)")
      ->type_name("NAME|INDEX");
  command.add_flag("--quiet", request.quiet, "no summary each second and no warnings; the final summary stays");
}

}  // namespace tactel::host
