// The images that materials use: fetched and decoded on all cores, then given to scene.textures. A
// broken image is repaired: a base colour becomes a checker, an emission goes dark, every other use
// is left out.
#include <algorithm>
#include <map>
#include <mutex>

#include "core/base/parallel.h"
#include "core/base/text.h"
#include "core/gltf/guard.h"
#include "core/gltf/parts.h"
#include "core/gltf/texture_image.h"

namespace core::gltf {

namespace {

/// One image and the textures that are made of it.
struct Job {
    size_t image = 0;
    std::vector<size_t> textures;
    // Results:
    std::string name, problem, damage;
    Bytes file;  // emptied after decoding
    ContentHash hash;
    uint64_t fileBytes = 0, repaired = 0;
};

std::vector<Job> makeJobs(const std::vector<TextureRequest>& requests)
{
    std::map<size_t, Job> byImage;
    for (size_t i = 0; i < requests.size(); ++i) {
        Job& job = byImage[requests[i].image];
        job.image = requests[i].image;
        job.textures.push_back(i);
    }
    std::vector<Job> jobs;
    for (auto& [image, job] : byImage) jobs.push_back(std::move(job));
    return jobs;
}

/// The encoded bytes; sets job.problem when there are none. The document was checked to hold an
/// array of images.
std::span<const std::byte> fetch(Load& load, Job& job)
{
    const Json image = (*load.document.root().find("images"))[job.image];
    if (!image.isObject()) {
        job.problem = "is " + describe(image) + ", must be an object";
        return {};
    }
    if (const std::optional<Json> name = image.find("name"); name && name->isString())
        job.name = printable(name->text(), kLongestName);
    const std::optional<Json> uri = image.find("uri"), view = image.find("bufferView");
    if (!uri == !view) {
        job.problem =
            uri ? "has both 'uri' and 'bufferView'" : "has neither 'uri' nor 'bufferView'";
        return {};
    }
    if (view) {
        const std::optional<uint64_t> index = wholeNumber(*view);
        if (index && *index < countOf(load, "bufferViews")) return bufferViewBytes(load, *index);
        job.problem = "refers to bufferView " + describe(*view) + ", there are " +
                      std::to_string(countOf(load, "bufferViews"));
        return {};
    }
    if (!uri->isString()) {
        job.problem = "has the uri " + describe(*uri) + ", must be a string";
        return {};
    }
    const std::string_view text = uri->text();
    if (job.name.empty() && !isDataUri(text)) job.name = printable(text, kLongestName);
    Content content = readUri(load, text);
    job.problem = std::move(content.problem);
    job.file = std::move(content.bytes);
    job.hash.add(job.file);
    job.fileBytes = job.file.size();
    return job.file;
}

void run(Load& load, Job& job, std::mutex& mutex)
{
    const std::span<const std::byte> bytes = fetch(load, job);
    if (!job.problem.empty()) return;
    ImageGuards guards;
    guards.maxSize = load.options.maxTextureSize;
    guards.beforeAllocation = [&](uint64_t pixels, uint64_t rawBytes) {
        const std::lock_guard lock(mutex);
        load.reserveMemory(rawBytes + pixels * sizeof(Texel) * job.textures.size(),
                           child("/images", job.image));
    };
    DecodedImage decoded = decodeImage(bytes, guards, load.stop);
    job.file = {};
    job.problem = std::move(decoded.problem);
    job.damage = std::move(decoded.damage);
    if (!job.problem.empty()) return;
    for (const size_t texture : job.textures) {
        load.scene.textures[texture] =
            makeTexture(decoded.image, load.textureRequests[texture].color, job.repaired);
        load.scene.textures[texture].name = job.name;
    }
}

/// Takes a texture that could not be made out of every material that has it.
void replace(Load& load, size_t texture)
{
    load.scene.textures[texture] = checkerTexture();
    for (Material& material : load.scene.materials)
        for (size_t slot = 0; slot < material.textures.size(); ++slot) {
            const int use = material.textures[slot];
            if (use < 0 || slot == shared::kTextureBaseColor) continue;
            if (load.scene.textureUses[static_cast<size_t>(use)].texture !=
                static_cast<int>(texture))
                continue;
            material.textures[slot] = -1;
            if (slot == shared::kTextureEmissive) material.data.emissive = glm::vec3(0);
        }
}

}  // namespace

void readTextures(Load& load)
{
    load.stage("textures", 0);
    load.scene.textures.resize(load.textureRequests.size());
    std::vector<Job> jobs = makeJobs(load.textureRequests);
    std::mutex mutex;
    size_t done = 0;
    parallelFor(
        jobs.size(), 1,
        [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                run(load, jobs[i], mutex);
                const std::lock_guard lock(mutex);
                load.stage("textures", static_cast<double>(++done) / double(jobs.size()));
            }
        },
        load.stop);
    load.checkpoint();
    for (Job& job : jobs) {
        const std::string pointer = child("/images", job.image);
        const uint64_t value = job.hash.value();
        if (job.fileBytes > 0) load.hash.add(std::as_bytes(std::span(&value, 1)));
        load.scene.fileBytes += job.fileBytes;
        if (!job.problem.empty()) {
            load.warn("IMAGE_UNUSABLE", pointer,
                      job.problem +
                          " — a checker stands for it as base colour, other uses are left out");
            for (const size_t texture : job.textures) replace(load, texture);
            // The scene differs from one in which the same bytes could be used.
            load.hash.add(std::as_bytes(std::span("replaced", 8)));
        }
        if (!job.damage.empty())
            load.warn("IMAGE_DAMAGED", pointer, job.damage + " — shown as far as it could be read");
        if (job.repaired > 0)
            load.warn("IMAGE_INVALID_VALUES", pointer,
                      std::to_string(job.repaired) +
                          " values are negative, not finite or above 65504 — replaced");
    }
    for (TextureUse& use : load.scene.textureUses) {
        const Texture& texture = load.scene.textures[static_cast<size_t>(use.texture)];
        use.record.width = texture.width;
        use.record.height = texture.height;
    }
}

}  // namespace core::gltf
