// JSON text and files. See json_file.h.
#include "app/base/json_file.h"

#include "app/base/files.h"
#include "core/base/check.h"
#include "core/base/json_scan.h"

namespace app {

using Json = nlohmann::ordered_json;

Json parseJson(const std::string& text, const std::string& place)
{
    // Sizes of nlohmann's nodes on 64 bits: a value in an array, a key-value node, an object's or
    // array's header.
    constexpr uint64_t kValueBytes = 32, kKeyBytes = 80, kContainerBytes = 48;
    constexpr uint64_t kMaxTree = uint64_t{1} << 30;
    const core::JsonScan scan = core::scanJson(text);
    if (!scan.problem.empty()) throw core::Error(place + ": not JSON: " + scan.problem);
    const uint64_t bytes = text.size() + scan.commas * kValueBytes + scan.colons * kKeyBytes +
                           scan.containers * kContainerBytes;
    if (bytes > kMaxTree)
        throw core::Error(place + ": would take " + std::to_string(bytes >> 20) +
                          " MiB of memory, allowed are " + std::to_string(kMaxTree >> 20));
    try {
        return Json::parse(text);
    } catch (const Json::parse_error& error) {
        throw core::Error(place + ": not JSON: at byte " + std::to_string(error.byte));
    } catch (const Json::exception&) {
        // The only valid JSON that cannot be represented: a number beyond the range of double.
        throw core::Error(place + ": holds a number that is too large");
    }
}

std::string jsonText(const Json& json, int indent)
{
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json readJson(const std::filesystem::path& file)
{
    return parseJson(readText(file), file.string());
}

}  // namespace app
