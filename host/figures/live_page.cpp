// SPDX-License-Identifier: Apache-2.0
#include "host/figures/live_page.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/figures/page.h"

namespace tactel::host {
namespace {

std::string pad_html(std::size_t k) {
  return fmt::format("<div><p class=\"pad-name\" id=\"name-{0}\"></p><div id=\"pad-{0}\"></div></div>\n", k);
}

}  // namespace

std::string html(const LivePage& page) {
  nlohmann::ordered_json setup{{"signal", page.signal}, {"bound", page.bound}, {"alarm", nullptr}};
  if (std::isfinite(page.alarm)) setup["alarm"] = page.alarm;
  std::string pads;
  for (const LivePage::Pad& pad : page.pads) {
    nlohmann::ordered_json one{{"name", pad.name}, {"tactels", nullptr}, {"pitch", pad.pitch}};
    if (pad.tactels[0] > 0) one["tactels"] = pad.tactels;
    setup["pads"].push_back(std::move(one));
    pads += pad_html(setup["pads"].size() - 1);
  }
  return page_html(
      "tactel: " + page.source,
      fmt::format(
          "<h1>tactel monitor</h1>\n<p class=\"subtitle\">{}</p>\n<p class=\"state fact\" id=\"state\"><b>waiting</b> "
          "<span>for the first frame</span></p>\n<div class=\"live\"><figure><div class=\"readout\" "
          "id=\"readout\"></div>"
          "<div class=\"legend\" id=\"key\"></div><div id=\"history\"></div><div id=\"truth\"></div></figure>\n"
          "<figure><div class=\"live-pads\">{}</div><div class=\"legend\" id=\"scale\"></div></figure></div>\n"
          "<div id=\"drift\"></div>\n<script type=\"application/json\" id=\"setup\">{}</script>\n",
          escaped(page.source), pads, script_json(setup)),
      live_script());
}

}  // namespace tactel::host
