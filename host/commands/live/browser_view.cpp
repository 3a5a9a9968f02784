// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <set>

#include "host/commands/live/monitor.h"
#include "host/figures/page.h"

namespace tactel::host {

namespace {

/// Of pads: those of their profiles, or calibrations, where each has one of another name, as left.toml and right.toml;
/// else they are counted.
std::vector<std::string> names_of(const MonitorRequest& request, std::size_t pads) {
  for (const std::vector<std::string>* files : {&request.profiles, &request.calibrations}) {
    std::vector<std::string> names;
    for (const std::string& file : *files) names.push_back(std::filesystem::path(file).stem());
    const std::set<std::string> distinct(names.begin(), names.end());
    if (pads > 1 && distinct.size() == pads && names.size() == pads) return names;
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < pads; ++i) names.push_back(pads > 1 ? fmt::format("pad {}", i + 1) : "pad");
  return names;
}

}  // namespace

BrowserView::BrowserView(const MonitorRequest& request, const SensorProfile& profile, const char* target, bool bound) {
  if (request.serve.empty()) return;
  LivePage page{.source = request.source, .pads = {}, .signal = "moved"};
  if (request.options.signal == AlarmSignal::left) page.signal = "left";
  if (request.options.signal == AlarmSignal::slip) page.signal = target, page.bound = bound;
  if (request.alarm) page.alarm = *request.alarm;
  const std::vector<std::string> names = names_of(request, profile.pads.size());
  for (std::size_t i = 0; i < profile.pads.size(); ++i)
    page.pads.push_back({names[i], profile.pads[i].tactels, profile.pads[i].pitch});
  if (page.pads.empty()) page.pads.push_back({.name = "line"});
  const std::string& place = request.serve.front();
  server_ = std::make_unique<LiveServer>(place.empty() ? default_place : place, html(page), request.serve_hosts);
  say(fmt::format("note: open {} in a browser{}{}", server_->address(),
                  server_->others().empty() ? "" : "; all of the network may: ", fmt::join(server_->others(), ", ")));
}

void BrowserView::tell_silence(double seconds) {
  if (server_) server_->send(fmt::format("{{\"seconds\": {:.1f}}}", seconds), "silence");
}

}  // namespace tactel::host
