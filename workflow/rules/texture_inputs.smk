# What textures are made of, by method.
def seam_correction(*methods):
    """Return whether seams are corrected by method: as configured, else as registered."""
    chosen = config["textures"]["seam_correction"]
    return {
        name: chosen.get(name, TEXTURE_METHODS[name].seam_correction)
        for name in methods
    }


def decoder(method):
    """Return the texture model of a method by its name; none where nothing is decoded."""
    name = TEXTURE_METHODS[method].weights
    return {name: model_of(name)} if name else {}


@functools.cache
def texture_params(method):
    """Return what a method's tiles depend on beside a house."""
    models = decoder(method)
    corrected = seam_correction(method)
    return {"models": models, "hashes": hashes(models), "seam_correction": corrected}


def shown_in_3d(wildcards):
    """Return whether these textures are those of the 3D house."""
    return (wildcards.drop, wildcards.method) == ("0.0", config["house"]["method"])


def textures_of(wildcards):
    """Return what a house's textures depend on: hidden photos, the method's models, and more.

    Those of the 3D house alone are maps of whole surfaces.
    """
    return texture_params(wildcards.method) | {
        "hidden": hidden_at(wildcards.drop, wildcards),
        "maps": maps_of(wildcards),
        "walls": walls_of(wildcards),
    }


def maps_of(wildcards):
    """Return whether there are maps of whole surfaces beside these textures."""
    return shown_in_3d(wildcards) and config["house"]["surfaces"] == "maps"


def walls_of(wildcards):
    """Return which walls share a texture: accent walls have their own in the 3D house alone."""
    return config["house"]["walls"] if shown_in_3d(wildcards) else "room"


def texture_inputs(wildcards):
    """Return what a method takes from elsewhere: tiles, crops of other houses, made weights."""
    method = TEXTURE_METHODS[wildcards.method]
    library = method.library and f"{RESULTS}/texture_library.parquet"
    pool = method.crop_pool and POOL
    colours = (
        walls_of(wildcards) == "wall" and f"{RESULTS}/houses/{{house}}/colours.parquet"
    )
    patterns = maps_of(wildcards) and HAS_MASKS and PATTERNS
    weights = made(decoder(wildcards.method))
    return given(
        library=library, pool=pool, colours=colours, patterns=patterns, **weights
    )
