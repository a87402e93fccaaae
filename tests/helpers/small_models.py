from dataclasses import asdict

import torch

from plan2scene.textures.model.texture_model import Architecture, TextureModel
from plan2scene.weights import save_model_file


def write_texture_model(path, *, half=True, **architecture):
    """Write a model of width 4, Synth's by default; return it."""
    model = TextureModel(Architecture(width=4, **architecture))
    save_model_file(path, model.state_dict(), asdict(model.architecture), half=half)
    return model


def write_texture_models(texture, naive):
    torch.manual_seed(0)
    write_texture_model(texture)
    write_texture_model(naive, delta_hsv=False, substances=0)
