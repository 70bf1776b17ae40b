// Small glTF documents made in code.
#include "tests/support/gltf_fixture.h"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include <OpenImageIO/imageio.h>
#include <unistd.h>

namespace test {

std::string base64(std::span<const std::byte> bytes)
{
    static constexpr std::string_view alphabet =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        const size_t count = std::min<size_t>(3, bytes.size() - i);
        for (size_t k = 0; k < 3; ++k)
            group = group << 8 | (k < count ? static_cast<uint32_t>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k)
            text += k <= count ? alphabet[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

int Document::view(const void* data, size_t size, int stride)
{
    bin.resize((bin.size() + 3) / 4 * 4);
    Json view{{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", size}};
    if (stride > 0) view["byteStride"] = stride;
    const auto* begin = static_cast<const std::byte*>(data);
    bin.insert(bin.end(), begin, begin + size);
    json["bufferViews"].push_back(view);
    return static_cast<int>(json["bufferViews"].size()) - 1;
}

int Document::accessor(int bufferView, int componentType, size_t count, const char* type)
{
    json["accessors"].push_back({{"bufferView", bufferView},
                                 {"componentType", componentType},
                                 {"count", count},
                                 {"type", type}});
    return static_cast<int>(json["accessors"].size()) - 1;
}

Json& Document::material()
{
    if (!json.contains("materials")) {
        json["materials"].push_back(Json::object());
        primitive()["material"] = 0;
    }
    return json["materials"][0];
}

std::string Document::text() const
{
    Json complete = json;
    if (!complete.contains("buffers") && !bin.empty())
        complete["buffers"] =
            Json::array({{{"byteLength", bin.size()},
                          {"uri", "data:application/octet-stream;base64," + base64(bin)}}});
    return complete.dump();
}

std::vector<std::byte> Document::glb() const
{
    Json complete = json;
    if (!complete.contains("buffers"))
        complete["buffers"] = Json::array({{{"byteLength", bin.size()}}});
    std::string text = complete.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> binary = bin;
    binary.resize((binary.size() + 3) / 4 * 4);
    std::vector<std::byte> glb;
    const auto word = [&](uint64_t value) {
        for (int shift = 0; shift < 32; shift += 8)
            glb.push_back(static_cast<std::byte>(value >> shift & 0xff));
    };
    word(0x46546c67), word(2), word(12 + 8 + text.size() + 8 + binary.size());
    word(text.size()), word(0x4e4f534a);
    glb.insert(glb.end(), bytesOf(text).begin(), bytesOf(text).end());
    word(binary.size()), word(0x004e4942);
    glb.insert(glb.end(), binary.begin(), binary.end());
    return glb;
}

Document triangle()
{
    Document document;
    document.json = Json::parse(
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]})");
    document.values<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3", 3);
    document.values<uint16_t>({0, 1, 2}, kUnsignedShort, "SCALAR", 1);
    return document;
}

Document texturedTriangle(std::span<const std::byte> image)
{
    Document document = triangle();
    document.attributes()["TEXCOORD_0"] =
        document.values<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2", 2);
    const int view = document.view(image.data(), image.size());
    document.json["images"] = Json::array({{{"bufferView", view}, {"mimeType", "image/png"}}});
    document.json["textures"] = Json::array({{{"source", 0}}});
    document.material()["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
    return document;
}

std::span<const std::byte> bytesOf(const std::string& text)
{
    return std::as_bytes(std::span(text.data(), text.size()));
}

std::shared_ptr<const core::Scene> loadText(const std::string& text,
                                            const core::LoadOptions& options)
{
    try {
        return core::loadGltfFromMemory(bytesOf(text), "test.gltf", options);
    } catch (const core::Error& error) {
        ADD_FAILURE() << "refused: " << error.what();
        return nullptr;
    }
}

std::shared_ptr<const core::Scene> load(const Document& document, const core::LoadOptions& options)
{
    return loadText(document.text(), options);
}

Refusal refusal(const std::string& text, const core::LoadOptions& options)
{
    try {
        core::loadGltfFromMemory(bytesOf(text), "test.gltf", options);
    } catch (const core::LoadError& error) {
        EXPECT_EQ(error.code() == "", false);
        return {error.code(), error.pointer(), error.what()};
    }
    ADD_FAILURE() << "loaded: " << text.substr(0, 400);
    return {};
}

Refusal fileRefusal(const std::filesystem::path& file, const core::LoadOptions& options)
{
    try {
        core::loadGltf(file, options);
    } catch (const core::LoadError& error) {
        return {error.code(), error.pointer(), error.what()};
    }
    ADD_FAILURE() << "loaded: " << file;
    return {};
}

core::Warning warning(const core::Scene& scene, const std::string& code)
{
    std::string all;
    for (const core::Warning& warning : scene.warnings.listed) {
        if (warning.code == code) return warning;
        all += "\n" + warning.code + " " + warning.pointer + ": " + warning.message;
    }
    ADD_FAILURE() << "no warning " << code << " among:" << all;
    return {};
}

TemporaryFolder::TemporaryFolder()
{
    std::string name = (std::filesystem::temp_directory_path() / "rekindle-test-XXXXXX").string();
    path_ = mkdtemp(name.data());
}

TemporaryFolder::~TemporaryFolder()
{
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TemporaryFolder::write(const std::string& name,
                                             std::span<const std::byte> bytes) const
{
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream stream(path_ / name, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    return path_ / name;
}

std::filesystem::path TemporaryFolder::write(const std::string& name, const std::string& text) const
{
    return write(name, bytesOf(text));
}

namespace {

std::vector<std::byte> encode(const std::string& extension, uint32_t width, uint32_t height,
                              uint32_t channels, OIIO::TypeDesc type, const void* pixels)
{
    const TemporaryFolder folder;
    const std::string file = (folder.path() / ("image." + extension)).string();
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(file);
    OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height),
                         static_cast<int>(channels), type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("Compression", "jpeg:100");
    if (!output || !output->open(file, spec) || !output->write_image(type, pixels) ||
        !output->close())
        ADD_FAILURE() << "cannot write a test image ." << extension;
    std::ifstream stream(file, std::ios::binary);
    const std::string content{std::istreambuf_iterator<char>(stream), {}};
    const std::span<const std::byte> bytes = bytesOf(content);
    return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<uint8_t>& pixels)
{
    return encode(extension, width, height, channels, OIIO::TypeDesc::UINT8, pixels.data());
}

std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<uint16_t>& pixels)
{
    return encode(extension, width, height, channels, OIIO::TypeDesc::UINT16, pixels.data());
}

std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<float>& pixels)
{
    return encode(extension, width, height, channels, OIIO::TypeDesc::FLOAT, pixels.data());
}

}  // namespace test
