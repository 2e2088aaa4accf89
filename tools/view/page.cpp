// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/page.hpp"

#include "study/study_page.hpp"
#include "view/embedded.hpp"

#include <fmt/format.h>

namespace voxshell {

void write_page(const nlohmann::ordered_json &view, const PageData &data,
                const std::function<void(std::string_view)> &sink)
{
    sink(fmt::format("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta "
                     "name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n<link "
                     "rel=\"icon\" href=\"data:,\">\n<style>{}</style></head>\n",
                     page_text(view.value("title", "")), embedded::style));
    sink(embedded::body);
    sink(fmt::format("<!--\n{}-->\n", embedded::library_licence));
    for (const std::string_view library : {embedded::library, embedded::controls}) {
        sink(R"(<script type="text/plain" class="library">)");
        sink(deflated({reinterpret_cast<const std::uint8_t *>(library.data()), library.size()}));
        sink("</script>\n");
    }
    for (const std::string &blob : data.blobs()) {
        sink(R"(<script type="text/plain" class="blob">)");
        sink(blob);
        sink("</script>\n");
    }
    // Nothing in a text may end the element that it stands in.
    std::string text = view.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
    for (std::size_t at = 0; (at = text.find('<', at)) != text.npos; at += 6) text.replace(at, 1, "\\u003c");
    sink("<script type=\"application/json\" id=\"page\">" + text +
         "</script>\n<script>\n(() => {\n'use strict';\n");
    for (const std::string_view script : embedded::scripts) sink(script);
    sink("main();\n})();\n</script>\n</body></html>\n");
}

} // namespace voxshell
