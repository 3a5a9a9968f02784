// SPDX-License-Identifier: Apache-2.0
#include "host/commands/live/browser_view.h"

#include <fmt/format.h>

#include "host/figures/live_page.h"

namespace tactel::host {

BrowserView::BrowserView(const MonitorRequest& request, const SensorProfile& profile, const char* target, bool bound) {
  if (request.serve.empty()) return;
  LivePage page{.source = request.source, .pads = {}, .signal = "moved"};
  if (request.options.signal == AlarmSignal::slip) page.signal = target, page.bound = bound;
  if (request.alarm) page.alarm = *request.alarm;
  for (std::size_t i = 0; i < profile.pads.size(); ++i)
    page.pads.push_back({profile.pads.size() > 1 ? fmt::format("pad {}", i + 1) : "pad", profile.pads[i].tactels,
                         profile.pads[i].pitch});
  if (page.pads.empty()) page.pads.push_back({.name = "line"});
  const std::string& place = request.serve.front();
  server_ = std::make_unique<LiveServer>(place.empty() ? default_place : place, html(page));
  say("note: open " + server_->address() + " in a browser");
}

}  // namespace tactel::host
