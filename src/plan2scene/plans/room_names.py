"""Names of rooms in several languages, and the room type that each name means."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from functools import lru_cache

from plan2scene.house import ROOM_TYPES

#: Stems of the names of garages; see `_STEMS`.
_GARAGE = "garage gar garaje box_auto garagem garasje autotalli garaz garaj гараж"
#: The same of laundries and utility rooms.
_LAUNDRY = (
    "utility util laundry laund lndry ldry l_dry ldy buand lavanderia lavadero lavandaria "
    "bijkeuken hwr hauswirtschaft tvatt tvattstuga vaskerom bryggers kodinhoitohuone pralnia"
)
#: Stems of words (lower case, no accents; `_` for a space) by room type. The first type with a stem
#: in a name decides: "bathroom" is found before "room" could be. Indoor rooms of a use that has no
#: type (garage, office) are Unknown.
_STEMS = {
    "Bathroom": (
        "bath bathrm bathroom masterbath badez bad salle_de_bain salle_deau bano aseo bagno bth "
        "badk badkamer shower shwr shr dusche douche ducha doccia wc toil toilet toilette lav "
        "lavatory restroom washroom ens ensuite en_suite powder powd pwdr pwd pdr servizi sauna "
        "lavabo badrum dusch sdb sde duschbad banheiro "
        "casa_de_banho lavatorio bad_en_suite baderom badevaerelse toalett kylpyhuone "
        "kph khh kh ph sd_b elternbad gastebad "
        "pesuhuone suihku laz lazienka toaleta banyo tuvalet ванн санузел туалет душев"
        "אמבטיה שירותים מקלחת 浴室 洗面 トイレ 風呂 バス 厠"
    ),
    "Kitchen": (
        "kitchen kit kitch ktchn kuche kueche kuch kuchen kochen cuisine cuis cocina coc cucina "
        "cuc keuken kitchenette scullery "
        "pantry_kitchen butlers_pantry kok kokken kjokken kjk cozinha coz keittio kk kt kuchnia "
        "aneks_kuchenny mutfak кухн מטבח キッチン 台所 厨房"
    ),
    "Bedroom": (
        "bedroom bedrm bdrm br mbr schlaf sz chambre chbre dormitorio dorm habitacion hab camera "
        "cam cameretta slaapk slpk kinderz kind kids guest gastez nursery alcoba recamara cuarto "
        "eltern gaste alkovi alk "
        "bed sovrum sov letto ch suite quarto sovevaerelse vaerelse soverom makuuhuone mh "
        "sypialnia pokoj pok yatak_odasi спальн детск שינה ילדים 寝室 洋室 和室 子供部屋 主卧 卧室"
    ),
    "Balcony": "balcon balcony balc balkon balcone loggia balkong altan varanda parveke parv "
    "balkonu лоджия балкон מרפסת バルコニー ベランダ 阳台",
    "Terrace": (
        "terrace terrasse terraza terrazza terras terr patio deck porch portico veranda pavilion "
        "alfresco terraco terassi taras teras терраса テラス"
    ),
    "Outdoor": (
        "outdoor outside garden garten jardin giardino tuin yard courtyard carport exterior "
        "draussen hof parking jardim have hage piha autokatos ogrod bahce сад גינה חצר 庭"
    ),
    "Staircase": (
        "stair stairs staircase treppe treppenhaus escalier escalera scala scale trap "
        "escada trappe trappa portaat schody klatka_schodowa merdiven лестница מדרגות 階段"
    ),
    "Entrance": (
        "entry ent entrance entree eingang foyer vestibule recibidor entrada ingresso ingr lobby "
        "mudroom mud_room mud windfang vorraum draughtlobby entre eteinen et tk wiatrolap antre "
        "прихож тамбур כניסה 玄関"
    ),
    "Corridor": (
        "corridor hall hal hallway flur diele gang couloir pasillo corridoio disimp passage dgt "
        "deg landing degagement overloop distribuidor corredor korridor gangen aula kaytava "
        "przedp korytarz hol koridor коридор холл מסדרון פרוזדור 廊下 ホール"
    ),
    "Closet": (
        "closet wardrobe storage store stor sto abstell abst kammer dress dressing placard pl "
        "cellier armario vestidor trastero despensa ripostiglio rip sgabuzzino berging berg kast "
        "pantry ptry wip cupboard cupbd cpbd cpd walkin w_i speisekammer ankleide larder klk "
        "kladkammare forrad garderob bir wir wic sic robe linen lin cub rangement rgt lager "
        "arrumos roupeiro bod skab garderobe pukuhuone pukuh vaatehuone "
        "vh varasto garderoba gard spizarnia schowek kiler гардероб кладов ארון מחסן "
        "クローゼット 収納 押入 物入 納戸 储藏"
    ),
    "Unknown": (
        f"{_GARAGE} {_LAUNDRY} lift elevator "
        "aufzug ascenseur ascensor technical technik mech loft attic basement "
        "heizung heizungsraum keller cellar cave plant workshop werkstatt "
        "vaerksted verksted "
        "gym study stdy office buro arbeitsz bureau despacho ufficio werkkamer escritorio kontor "
        "tyohuone gabinet calisma_odasi кабинет"
    ),
    "Reception": (
        "living liv lvg reception wohnz wohnen wohn wz sejour sej salon sala soggiorno sogg woonk "
        "lounge lnge dining din diner sitting esszimmer essen salle_a_manger comedor pranzo "
        "eetkamer family fam den meals media cinema snug rumpus sunroom conservatory playroom "
        "library great_room great_rm drawing parlour parlor studio stube zimmer vardagsrum "
        "matplats allrum activity theatre estar stue stua spisestue spisestuen faellesrum alrum "
        "olohuone oh ruokailu ruok tupakeittio jadalnia salonu oturma_odasi yasam "
        "гостин зал столов סלון מגורים אוכל リビング ダイニング 居間 客厅 ldk"
    ),
}
#: Names that match only as a whole: "zimmer" alone is a bedroom (German); abbreviations.
_WHOLE = {"zimmer": "Bedroom", "pokoj dzienny": "Reception", "w i cl": "Closet", "k": "Kitchen"}
_WHOLE |= dict.fromkeys(("c", "cl", "st"), "Closet")
_TYPES = {name.lower(): name for name in ROOM_TYPES} | _WHOLE


#: Latin letters that Unicode does not decompose into a letter and an accent.
WRITTEN = str.maketrans(
    {"æ": "ae", "œ": "oe", "ø": "o", "ł": "l", "đ": "d", "ð": "d", "þ": "th", "ß": "ss", "ı": "i"}
    | {"Æ": "Ae", "Œ": "Oe", "Ø": "O", "Ł": "L", "Đ": "D", "Ð": "D", "Þ": "Th"}
)


@lru_cache(maxsize=1024)
def room_types(name: str) -> tuple[str, ...]:
    """Return the room types that a name means, in the order of its words; empty for none.

    A name may join several rooms ("Living / Kitchen"): each part is read alone. A room of a use
    that has no type ("Garage") is Unknown.
    """
    types: list[str] = []
    for part in re.split(r"(?<!\b[wW])[/+&,;|]| und | and | et | y | e | en ", f"{name} "):
        kind = _type_of(part)
        if kind is not None and kind not in types:
            types.append(kind)
    return tuple(kind for kind in types if kind != "Unknown") or tuple(types)


def is_garage(name: str) -> bool:
    """Return whether a name means a garage, and no room of another type."""
    return room_types(name) == ("Unknown",) and _has_stem(_words_of(name), _GARAGE)


def has_bare_floor(types: Sequence[str], name: str) -> bool:
    """Return whether a room is only a kitchen, laundry or entrance: few of them have a carpet."""
    laundry = room_types(name) == ("Unknown",) and _has_stem(_words_of(name), _LAUNDRY)
    return laundry or tuple(types) in (("Kitchen",), ("Entrance",))


def _type_of(text: str) -> str | None:
    """Return the room type of one name."""
    words = _words_of(text)
    plain = " ".join(words)
    if plain in _TYPES:
        return None if plain == "unknown" else _TYPES[plain]
    return next((kind for kind, stems in _STEMS.items() if _has_stem(words, stems)), None)


def _words_of(text: str) -> list[str]:
    """Return the words of a name, lower case and without accents."""
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text).translate(WRITTEN)
    plain = unicodedata.normalize("NFKC", _without_accents(plain)).lower()
    plain = re.sub(r"(?<=\b\w)[.](?=\w\b)|['’`´]", "", plain)  # "W.I.R.", "L'DRY"
    return re.sub(r"[\W\d_]+", " ", plain).split()


def _has_stem(words: Sequence[str], stems: str) -> bool:
    """Return whether the words of a name contain one of the `stems`."""
    joined = f"_{'_'.join(words)}"
    return any(
        ("_" in stem and f"_{stem}" in joined) or any(_is(word, stem) for word in words)
        for stem in stems.split()
    )


def _without_accents(text: str) -> str:
    """Return a text without the accents of Latin letters; other scripts keep their marks."""
    parts = []
    for letter in text:
        plain = unicodedata.normalize("NFKD", letter)
        parts.append(plain[0] if plain[:1].isascii() and len(plain) > 1 else letter)
    return "".join(parts)


def _is(word: str, stem: str) -> bool:
    """Return whether a word is a stem, its plural, or (long stems) begins or ends with it.

    In scripts without spaces it may be anywhere in a word; Hebrew and Russian words begin with it.
    """
    if not stem.isascii():
        return stem in word if stem > "\u3000" else word.startswith(stem)
    if word in (stem, f"{stem}s", f"{stem}es", f"{stem}n"):
        return True
    return len(stem) >= 5 and (word.startswith(stem) or word.endswith(stem))
