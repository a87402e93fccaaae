"""What people call rooms, in several languages, and the room type that each means."""

from __future__ import annotations

import re
import unicodedata

from plan2scene.house import ROOM_TYPES

#: Stems of words (lower case, no accents; `_` for a space) by room type. The first type that has a
#: stem of a word decides: "bathroom" is told before "room" could be.
_STEMS = {
    "Bathroom": (
        "bath bathroom masterbath badezimmer bad salle_de_bain salle_d'eau bano aseo bagno "
        "badkamer shower dusche douche ducha doccia wc toilet toilette lavatory restroom washroom "
        "ensuite en_suite powder servizi sauna lavabo badrum dusch"
    ),
    "Kitchen": ("kitchen kuche kueche cuisine cocina cucina keuken kitchenette pantry_kitchen kok"),
    "Bedroom": (
        "bedroom schlafzimmer schlafen chambre dormitorio habitacion camera cameretta "
        "slaapkamer kinderzimmer kind guest gastezimmer nursery alcoba recamara cuarto bed "
        "sovrum letto"
    ),
    "Balcony": "balcon balcony balkon balcone loggia balkong",
    "Terrace": (
        "terrace terrasse terraza terrazza terras patio deck porch veranda pavilion alfresco"
    ),
    "Outdoor": (
        "outdoor outside garden garten jardin giardino tuin yard garage carport exterior "
        "draussen hof parking"
    ),
    "Staircase": ("stair stairs staircase treppe treppenhaus escalier escalera scala scale trap"),
    "Entrance": (
        "entry entrance entree eingang foyer vestibule recibidor entrada ingresso lobby "
        "windfang draughtlobby entre"
    ),
    "Corridor": (
        "corridor hall hallway flur diele gang couloir pasillo corridoio disimpegno passage "
        "landing degagement overloop distribuidor"
    ),
    "Closet": (
        "closet wardrobe storage store abstellraum abstellkammer kammer dressing placard "
        "cellier armario vestidor trastero despensa ripostiglio sgabuzzino berging kast "
        "pantry utility laundry cupboard walkin speisekammer buanderie lavanderia lavadero "
        "ankleide bijkeuken technical larder klk kladkammare forrad garderob tvatt "
        "bir wir wic robe l'dry linen cub"
    ),
    "Reception": (
        "living reception wohnzimmer wohnen wohn sejour salon sala soggiorno woonkamer lounge "
        "dining sitting esszimmer essen salle_a_manger comedor pranzo eetkamer family den library "
        "great_room drawing parlour parlor office study buro arbeitszimmer bureau despacho "
        "studio ufficio werkkamer stube zimmer vardagsrum matplats allrum activity theatre"
    ),
}
#: Whole names: a room (German) that is for nothing else, and what stands on closets.
_WHOLE = {"zimmer": "Bedroom", "c": "Closet", "cl": "Closet", "w i cl": "Closet"}
_TYPES = {name.lower(): name for name in ROOM_TYPES} | _WHOLE


#: Latin letters that are no other letter with an accent.
_WRITTEN = str.maketrans(
    {"æ": "ae", "œ": "oe", "ø": "o", "ł": "l", "đ": "d", "ð": "d", "þ": "th", "ß": "ss", "ı": "i"}
    | {"Æ": "Ae", "Œ": "Oe", "Ø": "O", "Ł": "L", "Đ": "D", "Ð": "D", "Þ": "Th"}
)


def fit_id(name: str, otherwise: str) -> str:
    """Return a name as an id: letters without their accents; `otherwise` for another script."""
    plain = unicodedata.normalize("NFKD", name.translate(_WRITTEN))
    plain = plain.encode("ascii", "ignore").decode()
    made = re.sub(r"[^A-Za-z0-9_.-]+", "_", plain).lstrip("._-").rstrip("_")[:60]
    lost = any(map(str.isalpha, name)) and not re.search("[A-Za-z]", made)
    return otherwise if lost or not made else made


def free_id(name: str, taken: set[str], otherwise: str = "room") -> str:
    """Return an id made of a name that is not taken yet, and take it: lower case, numbered."""
    stem = re.sub(r"[^a-z0-9]+", "_", fit_id(name, otherwise).lower()).strip("_")[:40] or otherwise
    name_id, number = stem, 1
    while name_id in taken:
        number += 1
        name_id = f"{stem}_{number}"
    taken.add(name_id)
    return name_id


def room_types(name: str) -> tuple[str, ...]:
    """Return the room types that a name means, in the order of its words; empty for none.

    A name may join several rooms ("Living / Kitchen"): each is told alone.
    """
    types: list[str] = []
    for part in re.split(r"(?<!\b[wW])[/+&,;|]| und | and | et | y | e | en ", f"{name} "):
        kind = _type_of(part)
        if kind is not None and kind not in types:
            types.append(kind)
    return tuple(types)


def _type_of(text: str) -> str | None:
    """Return the room type of one name."""
    plain = unicodedata.normalize("NFKD", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text))
    plain = plain.encode("ascii", "ignore").decode().lower()
    plain = re.sub(r"[^a-z']+", " ", plain).strip()
    if plain in _TYPES:
        return None if plain == "unknown" else _TYPES[plain]
    words = plain.split()
    for kind, stems in _STEMS.items():
        for stem in stems.split():
            if ("_" in stem and stem in "_".join(words)) or any(_is(w, stem) for w in words):
                return kind
    return None


def _is(word: str, stem: str) -> bool:
    """Return whether a word is a stem, its plural, or (long stems) begins or ends with it."""
    if word in (stem, f"{stem}s", f"{stem}es", f"{stem}n"):
        return True
    return len(stem) >= 5 and (word.startswith(stem) or word.endswith(stem))
