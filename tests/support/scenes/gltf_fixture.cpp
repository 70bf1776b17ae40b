// Small glTF documents made in code.
#include "tests/support/scenes/gltf_fixture.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <jpeglib.h>
#include <png.h>
#include <unistd.h>

#include "core/image/png_file.h"
#include "tests/support/files/exr_fixture.h"
#include "tests/support/files/hdr_fixture.h"

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

std::vector<std::byte> encodeJpeg(uint32_t width, uint32_t height, uint32_t channels,
                                  const uint8_t* pixels)
{
    jpeg_error_mgr errors;
    jpeg_compress_struct jpeg;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&jpeg, &memory, &size);
    jpeg.image_width = width;
    jpeg.image_height = height;
    jpeg.input_components = static_cast<int>(channels);
    jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    for (uint32_t y = 0; y < height; ++y) {
        JSAMPROW row = const_cast<JSAMPROW>(pixels + size_t{y} * width * channels);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    const auto* first = reinterpret_cast<const std::byte*>(memory);
    const std::vector<std::byte> bytes(first, first + size);
    std::free(memory);
    return bytes;
}

/// 16 bits per channel, the most significant byte first.
std::vector<std::byte> encodeDeepPng(uint32_t width, uint32_t height, uint32_t channels,
                                     const std::vector<uint16_t>& pixels)
{
    static constexpr int kTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                     PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    std::vector<std::byte> bytes;
    std::vector<png_byte> stored;
    for (const uint16_t value : pixels) {
        stored.push_back(static_cast<png_byte>(value >> 8));
        stored.push_back(static_cast<png_byte>(value & 255));
    }
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    const auto append = [](png_structp writer, png_bytep from, size_t count) {
        const auto* first = reinterpret_cast<const std::byte*>(from);
        auto* to = static_cast<std::vector<std::byte>*>(png_get_io_ptr(writer));
        to->insert(to->end(), first, first + count);
    };
    png_set_write_fn(png, &bytes, append, nullptr);
    png_set_IHDR(png, info, width, height, 16, kTypes[channels - 1], PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (size_t y = 0; y < height; ++y)
        png_write_row(png, stored.data() + y * 2 * width * channels);
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

std::vector<std::byte> encodeExr(uint32_t width, uint32_t height, uint32_t channels,
                                 const std::vector<float>& pixels)
{
    tests::ExrPicture picture;
    picture.width = static_cast<int>(width);
    picture.height = static_cast<int>(height);
    for (uint32_t c = 0; c < channels; ++c) {
        const std::string name = c < 4 ? std::string(1, "RGBA"[c]) : "channel" + std::to_string(c);
        picture.planes.push_back({name, tests::ExrType::float32, {}, 1});
        for (size_t i = c; i < pixels.size(); i += channels)
            picture.planes.back().values.push_back(pixels[i]);
    }
    return tests::makeExr(picture);
}

}  // namespace

std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<uint8_t>& pixels)
{
    if (extension == "jpg") return encodeJpeg(width, height, channels, pixels.data());
    EXPECT_EQ(extension, "png");
    return core::encodePng("a test's image", width, height, channels, pixels);
}

std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<uint16_t>& pixels)
{
    EXPECT_EQ(extension, "png");
    return encodeDeepPng(width, height, channels, pixels);
}

std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<float>& pixels)
{
    if (extension == "exr") return encodeExr(width, height, channels, pixels);
    EXPECT_EQ(extension + std::to_string(channels), "hdr3");
    return tests::makeHdr(width, height, pixels);
}

}  // namespace test
