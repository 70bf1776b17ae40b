// JSON text and files. See json_file.h.
#include "app/base/json_file.h"

#include "app/base/files.h"
#include "core/base/check.h"

namespace app {

using Json = nlohmann::ordered_json;

Json parseJson(const std::string& text, const std::string& place)
{
    try {
        return Json::parse(text);
    } catch (const Json::parse_error& error) {
        throw core::Error(place + ": not JSON: at byte " + std::to_string(error.byte));
    } catch (const Json::exception&) {
        // The only valid JSON that cannot be represented: a number beyond the range of double.
        throw core::Error(place + ": holds a number that is too large");
    }
}

Json readJson(const std::filesystem::path& file)
{
    return parseJson(readText(file), file.string());
}

}  // namespace app
