// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "host/commands/add_option.h"
#include "host/commands/live/monitor.h"

namespace tactel::host {

void add_monitor_options(CLI::App& command, MonitorRequest& request) {
  add_sensor_options(command, request);
  add_option(command, "--network", request.networks,
             "network that evaluates the frames, see tactel train; of several pads once, or once for each; needed but "
             "with --rest",
             {.type = "FILE.onnx"});
  add_option(command, "--every", request.every, "print only every N-th frame", {.type = "N", .positive = true});
  add_option(command, "--seconds", request.seconds,
             "stop after this time, s (default: at the end of the source, or Ctrl-C)")
      ->check(positive_number());
  add_option(command, "--late", request.options.late, "drop and count live frames older than this, s")
      ->check(positive_number());
  add_option(command, "--touch", request.options.touch,
             "a frame whose normal stresses all stay below this is no contact: its S is null, and it ends an alarm; 0: "
             "every frame is a contact, MPa (default: 7 standard deviations of the noise in the calibration, see "
             "tactel tare, and at least the smallest peak that the network learnt)")
      ->check(not_negative_number());
  add_option(command, "--drift", request.options.drift,
             "compare this long at rest with offsets and noise of the calibration, and say which channels no longer "
             "fit; twice the time constant of charge amplifiers, or more; 0: never, s")
      ->check(not_negative_number());
  add_option(command, "--view", request.view,
             "a picture instead of lines: S and its history, the tactels' stresses as blocks, shear with its "
             "direction; of pads a tile a tactel, shaded by pressure, with an arrow of shear");
  add_option(command, "--serve", request.serve,
             "a page for browsers beside the lines: pads or the line, what the alarm judges over ten seconds, and the "
             "truth of a simulation; PORT of this machine alone, or ADDRESS:PORT, 0.0.0.0:8080 for a telephone beside "
             "the gripper; port 0: any (default: 8080)",
             {.type = "PLACE"})
      ->expected(0, 1)
      ->allow_extra_args();
  add_option(
      command, "--serve-host", request.serve_hosts,
      "a name of this machine by which browsers may ask for the page, beside localhost and addresses; repeatable",
      {.type = "NAME"})
      ->needs("--serve");
  add_option(command, "--stresses", request.stresses, "add \"stresses\" to each line: all tactels, axis by axis, MPa");
  add_option(
      command, "--alarm", request.alarm_given,
      "add \"alarm\" to each line: true from this upper bound of S on (S itself where the network has no bound), false "
      "again 0.05 below; a line where it changes is always printed; --view shows it, too; with --signal left or moved "
      "from this \"left\" or \"moved\" on, with a network of slid from this answer on, no unit (default: 0.8; of left "
      "1; of moved that of tactel tare --hold; of slid that or the network's own)",
      {.type = "FLOAT"})
      ->expected(0, 1)
      ->allow_extra_args()
      ->check(CLI::Range(0.0f, 100.0f));
  add_option(command, "--rest", request.options.rest,
             "add \"rest\", whether a rest of the grip is known, \"moved\", the change of all stresses since, over the "
             "normal force then, \"calm\", the grip's tremor, and \"left\", how far it has left the rest; a line "
             "\"rest\" on standard input seeks rest anew, a line \"slides\" says that the object slides");
  add_option(command, "--signal", request.signal,
             "what --alarm acts on: slip, S or its bound; left or moved of --rest (default: left with --rest, but for "
             "a network of S)",
             {.words = {"slip", "left", "moved"}});
  add_option(command, "--friction", request.options.friction,
             "mu, as far as it is known, for networks of train --friction; while an object slides, a line \"slides\" "
             "on standard input has it read",
             {.type = "MU", .least = 1e-3, .most = 1e3})
      ->default_str("");
  add_option(command, "--friction-spread", request.options.friction_spread, "relative standard deviation of that mu",
             {.type = "FLOAT", .most = 1e3})
      ->needs("--friction");
  add_option(command, "--friction-drift", request.options.friction_drift,
             "relative standard deviation by which mu, as read from a slide, drifts in the next minute; it is trusted "
             "less with the root of time",
             {.type = "FLOAT", .most = 1e3});
  add_option(command, "--hold", request.options.hold,
             "with --alarm: it begins at the last of so many frames in a row that ask for it",
             {.type = "N", .least = 1, .most = 1000000})
      ->needs("--alarm");
  add_option(command, "--unlike", request.unlike,
             "with --alarm: what a frame does that is unlike those learnt, of which the network cannot tell S: alarm, "
             "or ignore: the alarm goes by S",
             {.words = {"alarm", "ignore"}})
      ->needs("--alarm");
  add_option(
      command, "--widest", request.widest,
      "with --alarm: no alarm begins at a frame with a wider interval of S, which is then \"cannot_tell\", no unit",
      {.type = "FLOAT", .most = 2.0})
      ->needs("--alarm")
      ->excludes("--view");
  add_option(command, "--device", request.device,
             "OpenCL device that evaluates the networks, all pads by one launch; gpu, cpu, or as of `tactel devices` "
             "(default: host code, with the same bits, quicker for a sensor or two)",
             {.type = "NAME|INDEX"});
  add_option(command, "--quiet", request.quiet, "no summary each second and no warnings; the final summary stays");
}

}  // namespace tactel::host
