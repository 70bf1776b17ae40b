// Text files and numbered names. See files.h.
#include "app/base/files.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

namespace {

std::string systemText()
{
    return std::strerror(errno);
}

struct NumberPlace {
    size_t start = 0, length = 0;
    uint32_t width = 0;
    bool zeros = false;
};

/// The only %d of a name; nothing when there is none, several, or another use of %.
std::optional<NumberPlace> numberPlace(const std::string& name)
{
    const size_t start = name.find('%');
    if (start == std::string::npos || name.find('%', start + 1) != std::string::npos) return {};
    NumberPlace place{start, 1, 0, false};
    size_t i = start + 1;
    if (i < name.size() && name[i] == '0') {
        place.zeros = true;
        ++i;
    }
    if (i < name.size() && std::isdigit(static_cast<unsigned char>(name[i])))
        place.width = static_cast<uint32_t>(name[i++] - '0');
    if (i >= name.size() || name[i] != 'd') return {};
    place.length = i + 1 - start;
    return place;
}

}  // namespace

std::string readText(const fs::path& file, uint64_t maxBytes)
{
    std::error_code error;
    if (!fs::exists(file, error)) throw core::Error(file.string() + ": no such file");
    if (!fs::is_regular_file(file, error))
        throw core::Error(file.string() + ": not a regular file");
    if (fs::file_size(file, error) > maxBytes)
        throw core::Error(file.string() + ": larger than " + std::to_string(maxBytes >> 20) +
                          " MiB");
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!stream) throw core::Error(file.string() + ": cannot be read: " + systemText());
    return text;
}

bool isNumbered(const fs::path& file)
{
    return numberPlace(file.filename().string()).has_value();
}

fs::path numbered(const fs::path& file, uint32_t number)
{
    std::string name = file.filename().string();
    const std::optional<NumberPlace> place = numberPlace(name);
    CHECK(place.has_value());
    std::string digits = std::to_string(number);
    if (digits.size() < place->width)
        digits.insert(0, place->width - digits.size(), place->zeros ? '0' : ' ');
    name.replace(place->start, place->length, digits);
    return file.parent_path() / name;
}

std::optional<uint32_t> numberIn(const fs::path& file, const std::string& name)
{
    const std::string pattern = file.filename().string();
    const std::optional<NumberPlace> place = numberPlace(pattern);
    CHECK(place.has_value());
    const size_t around = pattern.size() - place->length;
    if (name.size() <= around) return {};
    std::string_view digits = std::string_view(name).substr(place->start, name.size() - around);
    digits.remove_prefix(std::min(digits.find_first_not_of(' '), digits.size()));
    uint32_t number = 0;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    const bool isNumber = read.ec == std::errc() && read.ptr == digits.data() + digits.size();
    if (!isNumber || numbered(file, number).filename() != name) return {};
    return number;
}

}  // namespace app
