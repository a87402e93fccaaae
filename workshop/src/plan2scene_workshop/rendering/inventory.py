"""The furniture of rooms in training photos: classes by room type, and their makers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plan2scene_workshop.rendering import living, pieces, randomised, service
from plan2scene_workshop.rendering.pieces import Maker

_KITCHEN = ("kitchen", 2.2), ("fitted kitchen", 0.9), ("appliance", 1.2), ("tall unit", 0.5)
#: For each room type: classes along walls and free-standing classes, with the mean count of each.
ALONG_WALLS: Mapping[str, Sequence[tuple[str, float]]] = {
    "Reception": (
        *(("sofa", 1.4), ("tv", 0.8), ("shelf", 1.2), ("cabinet", 1.0), ("plant", 1.0)),
        *(("lamp", 0.7), ("desk", 0.4), ("armchair", 0.6), ("small", 2.0), ("fireplace", 0.15)),
        *(("piano", 0.15), ("tall unit", 0.4), ("chair", 0.7), ("table", 0.4), ("screen", 0.1)),
    ),
    "Bedroom": (
        *(("bed", 1.3), ("nightstand", 1.4), ("wardrobe", 0.5), ("tall unit", 0.7)),
        *(("cabinet", 0.8), ("desk", 0.6), ("shelf", 0.6), ("small", 2.2), ("plant", 0.4)),
        *(("chair", 0.5), ("armchair", 0.3), ("lamp", 0.4), ("tv", 0.3)),
    ),
    "Kitchen": (*_KITCHEN, ("shelf", 0.4), ("small", 1.0), ("plant", 0.3), ("chair", 0.6)),
    "Bathroom": (
        *(("sanitary", 2.6), ("cabinet", 0.4), ("appliance", 0.5), ("small", 1.0)),
        *(("shelf", 0.3), ("stool", 0.3)),
    ),
    "Corridor": (
        *(("cabinet", 0.7), ("shelf", 0.7), ("small", 1.6), ("plant", 0.4), ("chair", 0.4)),
        *(("tall unit", 0.4), ("coats", 0.5)),
    ),
    "Closet": (("wardrobe", 0.8), ("shelf", 1.0), ("small", 2.5), ("carton", 1.0)),
    "Outdoor": (("plant", 2.0), ("chair", 1.0), ("small", 1.0)),
    "Office": (
        *(("desk", 2.2), ("shelf", 2.2), ("cabinet", 1.0), ("table", 0.8), ("small", 2.5)),
        *(("chair", 1.5), ("carton", 0.8), ("plant", 0.5), ("tall unit", 0.3)),
    ),
}
STANDING_FREE: Mapping[str, Sequence[tuple[str, float]]] = {
    "Reception": (
        *(("coffee table", 0.9), ("dining set", 0.8), ("armchair", 0.6), ("stool", 0.6)),
        *(("small", 1.8), ("heap", 0.4), ("toys", 0.7), ("papers", 0.3), ("chair", 0.5)),
    ),
    "Bedroom": (("stool", 0.5), ("small", 1.5), ("heap", 0.8), ("toys", 0.6), ("papers", 0.4)),
    "Kitchen": (("dining set", 0.8), ("stool", 0.6), ("small", 0.6)),
    "Bathroom": (("small", 0.5), ("heap", 0.3)),
    "Corridor": (("small", 0.6), ("toys", 0.3)),
    "Outdoor": (("dining set", 0.6), ("chair", 0.6)),
    "Office": (("dining set", 1.2), ("chair", 2.5), ("table", 1.0), ("small", 1.0), ("papers", 1)),
}
#: Kinds of furniture of which some rooms are full ("rows" are rows of seats).
BULK = ("racks", "counters", "tables", "rows", "cupboards", "beds")
#: Classes that stay in a room after people moved out.
BUILT_IN = ("kitchen", "fitted kitchen", "sanitary", "fireplace")
#: Procedural makers of classes, used where the folder of models lacks one, and sometimes otherwise.
MAKERS: Mapping[str, Sequence[Maker]] = {
    "sofa": (living.sofa,),
    "bed": (living.bed,),
    "chair": (pieces.chair,),
    "armchair": (living.armchair,),
    "desk": (living.desk,),
    "shelf": (living.bookshelf,),
    "cabinet": (living.dresser,),
    "wardrobe": (living.wardrobe,),
    "nightstand": (living.night_table,),
    "plant": (service.plant,),
    "lamp": (living.floor_lamp,),
    "small": (randomised.toys, randomised.basket, service.carton),
    "tv": (living.television,),
    "stool": (living.ottoman,),
    "table": (living.coffee_table,),
    "coffee table": (living.coffee_table,),
    "dining set": (living.dining_set,),
    "fitted kitchen": (service.kitchen_run,),
    "appliance": (service.fridge, service.washer),
    "sanitary": (service.basin, service.toilet, service.bathtub),
    "coats": (service.coat_rack,),
    "carton": (service.carton,),
    "heap": (randomised.heap,),
    "toys": (randomised.toys,),
}
