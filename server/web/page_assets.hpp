#pragma once

#include <span>
#include <string_view>

namespace feltwire {

// A file of the live page, as it is compiled into the server (cmake/web_page.cmake).
struct PageAsset {
  std::string_view path;                // of the request: "/" or "/app.js"
  std::string_view type;                // Content-Type
  std::string_view sha256;              // of the content before compression, in hex
  std::span<const unsigned char> gzip;  // the content, for Content-Encoding: gzip
};

// All files of the page; none if the build left the page out (FELTWIRE_WEB=OFF).
std::span<const PageAsset> page_assets() noexcept;

}  // namespace feltwire
