// SPDX-License-Identifier: Apache-2.0
#include "host/commands/devices_command.h"

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/live/sensor_profile.h"
#include "hw/usb_source.h"

namespace tactel::host {

std::string devices_table(std::span<const DeviceInfo> devices) {
  std::string text = fmt::format("{:>2} {:5} {:>5} {:>10} {:>10}  {}\n", "", "type", "units", "fp32 lanes",
                                 "fp64 lanes", "name (driver)");
  const int taken = default_device(devices);
  for (const DeviceInfo& info : devices)
    text += fmt::format("{:>2}{}{:5} {:>5} {:>10} {:>10}  {} ({}){}\n", info.index, info.index == taken ? '*' : ' ',
                        name(info.type), info.compute_units, info.lanes_fp32,
                        info.fp64 ? std::to_string(info.lanes_fp64) : "-", info.name, info.driver,
                        info.low_latency ? ", low latency, on host threads" : "");
  return text + "* default device\n";
}

std::string devices_json(std::span<const DeviceInfo> devices) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  const int taken = default_device(devices);
  for (const DeviceInfo& info : devices)
    list.push_back({{"index", info.index},
                    {"name", info.name},
                    {"platform", info.platform},
                    {"driver", info.driver},
                    {"type", name(info.type)},
                    {"compute_units", info.compute_units},
                    {"memory", memory_of(info)},
                    {"fp64", info.fp64},
                    {"lanes", {{"fp32", info.lanes_fp32}, {"fp64", info.lanes_fp64}}},
                    {"low_latency", info.low_latency},
                    {"default", info.index == taken}});
  return list.dump(2) + "\n";
}

int devices_command(bool json, std::ostream& out, std::ostream& complaints) {
  const std::vector<DeviceInfo> devices = list_devices();
  if (json)
    out << devices_json(devices);
  else if (!devices.empty())
    out << devices_table(devices);
  if (const std::string hidden = hidden_gpu_advice(devices); !hidden.empty()) complaints << hidden << "\n";
  if (!devices.empty()) return 0;
  complaints << "no OpenCL device; " << no_device_advice() << "\n";
  return 3;
}

namespace {

struct DevicesRequest {
  bool json = false, sensors = false;
};

int run_devices(const DevicesRequest& request) {
  return (request.sensors ? sensors_command : devices_command)(request.json, std::cout, std::cerr);
}

/// The source of --source, and the profile that it takes.
std::pair<std::string, std::string> source_of(const hw::ListedUsb& device) {
  const hw::UsbDevice glove = built_in_profile("glove").usb;
  if (device.vendor == glove.vendor && device.product == glove.product) return {"usb:glove", "built in"};
  return {fmt::format("usb:{:04x}:{:04x}", device.vendor, device.product),
          device.is_serial ? "--profile, transport cdc-acm" : "--profile"};
}

}  // namespace

int sensors_command(bool json, std::ostream& out, std::ostream& complaints) {
  const std::vector<hw::ListedUsb> devices = hw::list_usb();
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const hw::ListedUsb& device : devices) {
    const auto [source, profile] = source_of(device);
    if (json)
      list.push_back({{"source", source},
                      {"profile", profile},
                      {"port", device.place.port},
                      {"serial", device.place.serial},
                      {"name", device.name},
                      {"refusal", device.refusal}});
    else
      out << fmt::format("{:14} {:28} {} {}\n", source, profile, place_text(device.place),
                         device.refusal.empty() ? device.name : device.refusal);
  }
  if (json) out << list.dump(2) << "\n";
  if (!devices.empty()) return 0;
  complaints
      << "no USB device that may send frames; connect the sensor: `lsusb` lists it once the system has found it, "
         "docs/sensors.md says which can be read\n";
  return 3;
}

void add_devices_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(app, action, "Set up", "devices",
                                              "list the OpenCL devices, with their lanes and precision", run_devices);
  add_option(command, "--json", request.json, "print JSON instead of the table");
  add_option(command, "--sensors", request.sensors,
             "list the USB devices that may be sensors instead, and the --source of each");
}

}  // namespace tactel::host
