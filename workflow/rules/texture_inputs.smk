# Functions for the inputs and params of rule textures, which differ by method.
def seam_correction(*methods):
    """Return for each method whether seams are corrected: as configured, else as registered."""
    chosen = config["textures"]["seam_correction"]
    return {
        name: chosen.get(name, TEXTURE_METHODS[name].seam_correction)
        for name in methods
    }


def decoder(method):
    """Return the texture model that a method decodes with, by name; empty if it has none."""
    name = TEXTURE_METHODS[method].weights
    return {name: model_of(name)} if name else {}


@functools.cache
def texture_params(method):
    """Return the params that are the same for all houses."""
    models = decoder(method)
    corrected = seam_correction(method)
    return {"models": models, "hashes": hashes(models), "seam_correction": corrected}


def shown_in_3d(wildcards):
    """Return whether the 3D house shows these textures."""
    return (wildcards.drop, wildcards.method) == ("0.0", config["house"]["method"])


def textures_of(wildcards):
    """Return the params of a house's textures by one method at one drop fraction."""
    return texture_params(wildcards.method) | {
        "hidden": hidden_at(wildcards.drop, wildcards),
        "maps": maps_of(wildcards),
    }


def maps_of(wildcards):
    """Return whether to make maps of whole surfaces too: only for the 3D house."""
    return shown_in_3d(wildcards) and config["house"]["surfaces"] == "maps"


def texture_inputs(wildcards):
    """Return the inputs that only some methods, or only the 3D house, have."""
    method = TEXTURE_METHODS[wildcards.method]
    library = method.library and f"{RESULTS}/texture_library.parquet"
    pool = method.crop_pool and POOL
    patterns = maps_of(wildcards) and HAS_MASKS and PATTERNS
    weights = made(decoder(wildcards.method))
    return given(library=library, pool=pool, patterns=patterns, **weights)
