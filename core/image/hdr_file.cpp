// See hdr_file.h. Every byte is taken through `Bytes`, which knows how many are left.
#include "core/image/hdr_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

namespace core {

namespace {

constexpr size_t kLongestLine = 4096, kLongestHeader = 1 << 16;
// Of lines packed channel by channel; other widths are packed in the old way.
constexpr uint32_t kNarrowest = 8, kWidest = 0x7fff;

using Rgbe = std::array<uint8_t, 4>;

class Bytes {
public:
    explicit Bytes(EncodedImage all) : all_(all) {}

    bool has(size_t count) const { return count <= all_.size() - at_; }
    /// Only after has().
    uint8_t next() { return static_cast<uint8_t>(all_[at_++]); }
    Rgbe peekPixel() const
    {
        Rgbe pixel;
        std::memcpy(pixel.data(), all_.data() + at_, pixel.size());
        return pixel;
    }
    void skip(size_t count) { at_ += count; }
    /// The text up to the end of the line, which is passed over; nothing when it is too long or cut
    /// off.
    std::optional<std::string_view> line()
    {
        const std::string_view rest(reinterpret_cast<const char*>(all_.data()) + at_,
                                    std::min(kLongestLine, all_.size() - at_));
        const size_t end = rest.find('\n');
        if (end == std::string_view::npos) return {};
        at_ += end + 1;
        return rest.substr(0, end);
    }
    size_t at() const { return at_; }
    size_t size() const { return all_.size(); }

private:
    EncodedImage all_;
    size_t at_ = 0;
};

/// How the lines of a file lie in the image. A line is a column where `columns` is set.
struct Layout {
    uint64_t width = 0, height = 0;
    bool columns = false, fromRight = false, fromBottom = false;

    uint64_t lines() const { return columns ? width : height; }
    uint32_t pixels() const { return static_cast<uint32_t>(columns ? height : width); }
};

/// One half of the line of sizes, such as "-Y 512": sign, axis and size.
bool takeAxis(std::string_view& text, char& sign, char& axis, uint64_t& size)
{
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (text.size() < 4 || text[2] != ' ') return false;
    sign = text[0];
    axis = text[1];
    text.remove_prefix(std::min(text.find_first_not_of(' ', 2), text.size()));
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
    if (error != std::errc()) return false;
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    return (sign == '+' || sign == '-') && (axis == 'X' || axis == 'Y');
}

/// The line of sizes: "-Y HEIGHT +X WIDTH" is the usual one, Y grows upwards.
std::optional<Layout> layoutOf(std::string_view text)
{
    std::array<char, 2> signs{}, axes{};
    std::array<uint64_t, 2> sizes{};
    for (size_t k = 0; k < 2; ++k)
        if (!takeAxis(text, signs[k], axes[k], sizes[k])) return {};
    if (axes[0] == axes[1] || text.find_first_not_of(" \r") != std::string_view::npos) return {};
    const size_t x = axes[0] == 'X' ? 0 : 1, y = 1 - x;
    return Layout{sizes[x], sizes[y], x == 0, signs[x] == '-', signs[y] == '+'};
}

/// Lines of text up to an empty one, then the line of sizes. Returns what is wrong.
std::string readHeader(Bytes& bytes, Layout& layout)
{
    for (;;) {
        const std::optional<std::string_view> line = bytes.line();
        if (!line || bytes.at() > kLongestHeader) return "is damaged: its header does not end";
        if (line->empty() || *line == "\r") break;
        if (line->starts_with("FORMAT=") && !line->starts_with("FORMAT=32-bit_rle_rgbe"))
            return "is in the format \"" + std::string(line->substr(7, 40)) +
                   "\", only 32-bit_rle_rgbe is read";
    }
    const std::optional<std::string_view> line = bytes.line();
    const std::optional<Layout> found = line ? layoutOf(*line) : std::nullopt;
    if (!found) return "is damaged: no size, such as \"-Y 512 +X 1024\", in its header";
    layout = *found;
    return {};
}

/// Unpacks one line after the other. Returns what is wrong with it; empty when nothing is.
class Lines {
public:
    Lines(Bytes& bytes, uint32_t width) : bytes_(bytes), pixels_(width) {}

    std::string read()
    {
        if (!bytes_.has(4)) return cutOff();
        const Rgbe start = bytes_.peekPixel();
        const bool packed = pixels_.size() >= kNarrowest && pixels_.size() <= kWidest &&
                            start[0] == 2 && start[1] == 2 && start[2] < 128;
        if (!packed) return readOld();
        if (size_t{start[2]} * 256 + start[3] != pixels_.size())
            return "is damaged: a line has another length than the image";
        bytes_.skip(4);
        for (size_t channel = 0; channel < 4; ++channel)
            if (std::string problem = readChannel(channel); !problem.empty()) return problem;
        return {};
    }

    const std::vector<Rgbe>& pixels() const { return pixels_; }

private:
    std::string cutOff() const
    {
        return "is damaged: cut off after " + std::to_string(bytes_.size()) + " bytes";
    }

    /// A count above 128 is a run of one value, up to 128 of that many values.
    std::string readChannel(size_t channel)
    {
        for (size_t x = 0; x < pixels_.size();) {
            if (!bytes_.has(2)) return cutOff();
            const uint8_t code = bytes_.next();
            const bool run = code > 128;
            const size_t count = run ? code - 128u : code;
            if (count == 0 || count > pixels_.size() - x)
                return "is damaged: a run leaves its line";
            if (!bytes_.has(run ? 1 : count)) return cutOff();
            if (run) {
                const uint8_t value = bytes_.next();
                for (size_t i = 0; i < count; ++i) pixels_[x + i][channel] = value;
            } else {
                for (size_t i = 0; i < count; ++i) pixels_[x + i][channel] = bytes_.next();
            }
            x += count;
        }
        return {};
    }

    /// Pixel by pixel; (1, 1, 1, n) repeats the one before, several of them count in base 256.
    std::string readOld()
    {
        unsigned shift = 0;
        for (size_t x = 0; x < pixels_.size();) {
            if (!bytes_.has(4)) return cutOff();
            const Rgbe pixel = bytes_.peekPixel();
            bytes_.skip(4);
            if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
                pixels_[x++] = pixel;
                shift = 0;
                continue;
            }
            const uint64_t count = shift <= 24 ? uint64_t{pixel[3]} << shift : ~uint64_t{0};
            if (x == 0 || count > pixels_.size() - x) return "is damaged: a run leaves its line";
            for (uint64_t i = 0; i < count; ++i, ++x) pixels_[x] = pixels_[x - 1];
            shift += 8;
        }
        return {};
    }

    Bytes& bytes_;
    std::vector<Rgbe> pixels_;
};

/// What a mantissa of one stands for, by exponent; an exponent of zero is black.
std::array<float, 256> makeScales()
{
    std::array<float, 256> scales{};
    for (int e = 1; e < 256; ++e) scales[static_cast<size_t>(e)] = std::ldexp(1.0f, e - 136);
    return scales;
}

/// Puts line number `line` where it belongs.
void place(const std::vector<Rgbe>& pixels, uint64_t line, const Layout& layout, RawImage& image)
{
    static const std::array<float, 256> kScales = makeScales();
    auto* values = reinterpret_cast<float*>(image.pixels.data());
    const auto address = [&](uint64_t i) {
        uint64_t x = layout.columns ? line : i, y = layout.columns ? i : line;
        if (layout.fromRight) x = layout.width - 1 - x;
        if (layout.fromBottom) y = layout.height - 1 - y;
        return static_cast<int64_t>(3 * (y * layout.width + x));
    };
    const int64_t step = pixels.size() > 1 ? address(1) - address(0) : 0;
    int64_t at = address(0);
    for (const Rgbe& pixel : pixels) {
        const float scale = kScales[pixel[3]];
        for (int64_t c = 0; c < 3; ++c)
            values[at + c] = static_cast<float>(pixel[static_cast<size_t>(c)]) * scale;
        at += step;
    }
}

}  // namespace

bool isHdr(EncodedImage bytes)
{
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE");
}

DecodedImage decodeHdr(EncodedImage encoded, const ImageGuards& guards, std::stop_token stop)
{
    const auto refused = [](std::string problem) {
        return DecodedImage{{}, std::move(problem), {}};
    };
    if (!isHdr(encoded)) return refused("is no Radiance picture");
    Bytes bytes(encoded);
    Layout layout;
    if (std::string problem = readHeader(bytes, layout); !problem.empty()) return refused(problem);
    if (std::string problem = sizeProblem(static_cast<double>(layout.width),
                                          static_cast<double>(layout.height), guards);
        !problem.empty())
        return refused(problem);
    RawImage image{static_cast<uint32_t>(layout.width),
                   static_cast<uint32_t>(layout.height),
                   3,
                   RawImage::Type::float32,
                   {}};
    if (std::string problem = allocatePixels(image, encoded.size(), 0, guards); !problem.empty())
        return refused(problem);
    Lines lines(bytes, layout.pixels());
    for (uint64_t line = 0; line < layout.lines(); ++line) {
        if (stop.stop_requested()) return refused("was not read: loading was stopped");
        if (std::string problem = lines.read(); !problem.empty()) return refused(problem);
        place(lines.pixels(), line, layout, image);
    }
    return {std::move(image), {}, {}};
}

}  // namespace core
