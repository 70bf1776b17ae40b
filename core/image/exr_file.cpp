// See exr_file.h. The library reports by exceptions, which none but `attempt` sees.
#include "core/image/exr_file.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <exception>
#include <fstream>
#include <functional>
#include <new>
#include <thread>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTileDescription.h>

#include "core/base/check.h"

namespace core {

namespace {

// Between two looks at the stop token; what is compressed together is read together.
constexpr uint64_t kStripBytes = 4 << 20;
// Threads cost more than they save below.
constexpr uint64_t kThreadedBytes = 1 << 20;

/// Runs `action`, in which the library may throw. Returns its complaint in one line; empty when it
/// has none.
std::string attempt(const std::function<void()>& action)
{
    try {
        action();
        return {};
    } catch (const std::bad_alloc&) {
        return "there is not enough memory";
    } catch (const std::exception& exception) {
        const std::string text = exception.what();
        const std::string line = text.substr(0, std::min<size_t>(text.find('\n'), 200));
        return line.empty() ? "unknown reason" : line;
    }
}

/// How many threads work on an image of so many bytes. The library's own threads start with the
/// first that is worth it.
int threadsFor(uint64_t bytes)
{
    if (bytes < kThreadedBytes) return 0;
    static const int kThreads = [] {
        const int count = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
        Imf::setGlobalThreadCount(count);
        return count;
    }();
    return kThreads;
}

/// Bytes in memory as the library reads them.
class Input : public Imf::IStream {
public:
    explicit Input(EncodedImage bytes) : Imf::IStream("image"), bytes_(bytes) {}

    bool read(char to[], int count) override
    {
        if (count < 0 || at_ > bytes_.size() || size_t(count) > bytes_.size() - at_)
            throw std::runtime_error("cut off after " + std::to_string(bytes_.size()) + " bytes");
        std::memcpy(to, bytes_.data() + at_, size_t(count));
        at_ += size_t(count);
        return at_ < bytes_.size();
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t at) override { at_ = at; }

private:
    EncodedImage bytes_;
    uint64_t at_ = 0;
};

/// A file as the library reads it: not held in memory beside its pixels.
class FileInput : public Imf::IStream {
public:
    explicit FileInput(const std::filesystem::path& file)
        : Imf::IStream("image"), stream_(file, std::ios::binary)
    {}

    bool read(char to[], int count) override
    {
        if (!stream_.read(to, count)) throw std::runtime_error("it ends too early");
        return true;
    }
    uint64_t tellg() override { return static_cast<uint64_t>(stream_.tellg()); }
    void seekg(uint64_t at) override { stream_.seekg(static_cast<std::streamoff>(at)); }
    void clear() override { stream_.clear(); }

private:
    std::ifstream stream_;
};

/// Bytes in memory as the library writes them: it comes back to fill in the table of lines.
class Output : public Imf::OStream {
public:
    explicit Output(std::vector<std::byte>& bytes) : Imf::OStream("image"), bytes_(bytes) {}

    void write(const char from[], int count) override
    {
        const size_t end = at_ + size_t(count);
        if (end > bytes_.size()) bytes_.resize(end);
        std::memcpy(bytes_.data() + at_, from, size_t(count));
        at_ = end;
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t at) override { at_ = at; }

private:
    std::vector<std::byte>& bytes_;
    uint64_t at_ = 0;
};

/// The values of one channel in an image: every `stride`th float from `first` on.
struct Plane {
    std::string name;
    float* first = nullptr;
    size_t stride = 1;
};

/// What the library wants: the address that the pixel (0, 0) would have, inside the image or not.
Imf::Slice sliceOf(const Plane& plane, uint32_t width, int left, int top)
{
    const size_t pixel = plane.stride * sizeof(float), row = pixel * width;
    const auto first = reinterpret_cast<uintptr_t>(plane.first);
    const uintptr_t origin =
        first - static_cast<uintptr_t>(left) * pixel - static_cast<uintptr_t>(top) * row;
    return Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), pixel, row);
}

/// Lines that are compressed together.
int linesPerChunk(const Imf::Header& header)
{
    if (header.hasTileDescription()) return static_cast<int>(header.tileDescription().ySize);
    switch (header.compression()) {
    case Imf::NO_COMPRESSION:
    case Imf::RLE_COMPRESSION:
    case Imf::ZIPS_COMPRESSION:
        return 1;
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
        return 16;
    case Imf::DWAB_COMPRESSION:
        return 256;
    default:
        return 32;
    }
}

/// Fills the planes; returns early when `stop` asks for it.
void readPlanes(Imf::InputFile& file, const std::vector<Plane>& planes, int threads,
                const std::stop_token& stop)
{
    const Imf::Header& header = file.header();
    const Imath::Box2i& window = header.dataWindow();
    const auto width = static_cast<uint32_t>(window.max.x - window.min.x + 1);
    Imf::FrameBuffer buffer;
    for (const Plane& plane : planes)
        buffer.insert(plane.name, sliceOf(plane, width, window.min.x, window.min.y));
    file.setFrameBuffer(buffer);
    const uint64_t chunkLines = static_cast<uint64_t>(linesPerChunk(header));
    const uint64_t chunkBytes = chunkLines * width * planes.size() * sizeof(float);
    const auto workers = static_cast<uint64_t>(std::max(threads, 1));
    const uint64_t chunks = std::max(kStripBytes / chunkBytes / workers, uint64_t{1}) * workers;
    const int64_t lines = static_cast<int64_t>(chunks * chunkLines);
    for (int64_t y = window.min.y; y <= window.max.y && !stop.stop_requested(); y += lines)
        file.readPixels(static_cast<int>(y),
                        static_cast<int>(std::min<int64_t>(y + lines - 1, window.max.y)));
}

/// The part of a channel's name before its last dot.
std::string layerOf(const std::string& name)
{
    const size_t dot = name.rfind('.');
    return dot == std::string::npos ? "" : name.substr(0, dot);
}

/// The part behind it, in lower case.
std::string suffixOf(const std::string& name)
{
    std::string suffix = name.substr(name.rfind('.') + 1);  // npos + 1 is 0
    for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return suffix;
}

/// Place of a channel among those of its layer. Z is a coordinate beside X, else a depth, which
/// comes last.
size_t rankOf(const std::string& suffix, bool coordinates)
{
    static const std::vector<std::vector<std::string>> kOrder{
        {"r", "red"}, {"g", "green"}, {"b", "blue"}, {"x"}, {"y"}, {"z"}, {"a", "alpha"}};
    for (size_t i = 0; i < kOrder.size(); ++i)
        if (std::find(kOrder[i].begin(), kOrder[i].end(), suffix) != kOrder[i].end())
            return suffix == "z" && !coordinates ? kOrder.size() : i;
    return kOrder.size() + 1;
}

/// The names of a layer's channels, in order.
struct LayerChannels {
    std::string layer;
    std::vector<std::string> names;
};

std::vector<LayerChannels> groupChannels(const std::vector<std::string>& names)
{
    std::map<std::string, std::vector<std::string>> layers;  // "" comes first
    for (const std::string& name : names) layers[layerOf(name)].push_back(name);
    std::vector<LayerChannels> groups;
    for (auto& [layer, channels] : layers) {
        bool coordinates = false;
        for (const std::string& name : channels) coordinates |= suffixOf(name) == "x";
        const auto key = [coordinates](const std::string& name) {
            return std::pair(rankOf(suffixOf(name), coordinates), name);
        };
        std::sort(channels.begin(), channels.end(),
                  [&](const auto& a, const auto& b) { return key(a) < key(b); });
        groups.push_back({layer, std::move(channels)});
    }
    return groups;
}

/// Whether the library has understood the header as the guard has.
bool agrees(const Imf::Header& header, const ExrHeader& claims)
{
    const Imath::Box2i& window = header.dataWindow();
    uint32_t channels = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) ++channels;
    return int64_t{window.max.x} - window.min.x + 1 == claims.width &&
           int64_t{window.max.y} - window.min.y + 1 == claims.height &&
           channels == claims.channels && header.hasTileDescription() == (claims.tileWidth > 0);
}

/// Channel names of a layer of `count` channels: colours by letter, single values as luminance.
std::string channelName(const std::string& layer, uint32_t channel, uint32_t count)
{
    static constexpr std::array<const char*, 4> kColours{"R", "G", "B", "A"};
    const std::string suffix = count == 1 ? "Y" : kColours[channel];
    return layer.empty() ? suffix : layer + "." + suffix;
}

constexpr const char* kContradiction = "EXR header contradicts itself";

}  // namespace

std::vector<std::byte> encodeExr(const std::string& name, const std::vector<Layer>& layers,
                                 const Metadata& strings)
{
    CHECK(!layers.empty());
    const uint32_t width = layers.front().image.width, height = layers.front().image.height;
    std::vector<std::byte> bytes;
    const std::string complaint = attempt([&] {
        Imf::Header header(static_cast<int>(width), static_cast<int>(height));
        header.compression() = Imf::ZIP_COMPRESSION;
        Imf::FrameBuffer buffer;
        uint64_t channels = 0;
        for (const auto& [layer, image] : layers) {
            CHECK(image.width == width && image.height == height);
            CHECK(image.channels >= 1 && image.channels <= 4);
            for (uint32_t c = 0; c < image.channels; ++c, ++channels) {
                const std::string channel = channelName(layer, c, image.channels);
                header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
                // The library does not write to what it is given to write from.
                auto* first = const_cast<float*>(image.pixels.data()) + c;
                buffer.insert(channel, sliceOf({channel, first, image.channels}, width, 0, 0));
            }
        }
        for (const auto& [key, value] : strings) header.insert(key, Imf::StringAttribute(value));
        Output output(bytes);
        Imf::OutputFile file(output, header,
                             threadsFor(uint64_t{width} * height * channels * sizeof(float)));
        file.setFrameBuffer(buffer);
        file.writePixels(static_cast<int>(height));
    });
    if (!complaint.empty()) throw Error(name + ": cannot be encoded: " + complaint);
    return bytes;
}

std::vector<Layer> readExrLayers(const std::filesystem::path& path, const ExrHeader& claims)
{
    const std::string name = path.string();
    const uint64_t floats = uint64_t{claims.width} * claims.height * claims.channels;
    const int threads = threadsFor(floats * sizeof(float));
    FileInput input(path);
    std::optional<Imf::InputFile> file;
    std::string complaint = attempt([&] { file.emplace(input, threads); });
    if (!complaint.empty()) throw Error(name + ": cannot be read (" + complaint + ")");
    if (!agrees(file->header(), claims)) throw Error(name + ": " + kContradiction);
    std::vector<Layer> layers;
    std::vector<Plane> planes;
    complaint = attempt([&] {
        for (const LayerChannels& group : groupChannels(claims.channelNames)) {
            const size_t count = group.names.size();
            layers.push_back({group.layer, Image(claims.width, claims.height, uint32_t(count))});
            float* first = layers.back().image.pixels.data();
            for (size_t c = 0; c < count; ++c) planes.push_back({group.names[c], first + c, count});
        }
        readPlanes(*file, planes, threads, {});
    });
    if (!complaint.empty()) throw Error(name + ": damaged or cut off (" + complaint + ")");
    return layers;
}

DecodedImage decodeExr(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop)
{
    const auto refused = [](std::string problem) {
        return DecodedImage{{}, std::move(problem), {}};
    };
    const std::optional<ExrHeader> claims = parseExrHeader(bytes);
    if (!claims) return refused("is damaged: no EXR header, or it is cut off");
    if (std::string problem = sizeProblem(claims->width, claims->height, guards); !problem.empty())
        return refused(problem);
    if (std::string problem = claims->problem(bytes.size()); !problem.empty())
        return refused(problem);
    if (claims->channels > 4)
        return refused("has " + std::to_string(claims->channels) + " channels, allowed are 1 to 4");
    RawImage image{claims->width, claims->height, claims->channels, RawImage::Type::float32, {}};
    const int threads = threadsFor(uint64_t{image.rowBytes()} * image.height);
    Input input(bytes);
    std::optional<Imf::InputFile> file;
    std::string complaint = attempt([&] { file.emplace(input, threads); });
    if (!complaint.empty()) return refused("cannot be read: " + complaint);
    if (!agrees(file->header(), *claims))
        return refused(std::string("is damaged: ") + kContradiction);
    if (std::string problem = allocatePixels(image, bytes.size(), 0, guards); !problem.empty())
        return refused(problem);
    std::vector<Plane> planes;
    auto* first = reinterpret_cast<float*>(image.pixels.data());
    for (const LayerChannels& group : groupChannels(claims->channelNames))
        for (const std::string& channel : group.names)
            planes.push_back({channel, first + planes.size(), image.channels});
    complaint = attempt([&] { readPlanes(*file, planes, threads, stop); });
    if (stop.stop_requested()) return refused("was not read: loading was stopped");
    if (!complaint.empty()) return refused("is damaged: " + complaint);
    return {std::move(image), {}, {}};
}

}  // namespace core
