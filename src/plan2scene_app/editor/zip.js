// ZIP archives are opened as folders: a home's plan and photos often come in one.

export const isZip = (file) => /\.zip$/i.test(file.name);

/** The files in a ZIP archive; of those in several folders each names its files, kitchen_1.jpg. */
export async function unzipped(archive) {
  const view = new DataView(await archive.arrayBuffer());
  const short = (at) => view.getUint16(at, true), long = (at) => view.getUint32(at, true);
  let end = view.byteLength - 22; // of the archive: its directory's place, and how many entries it has
  while (end >= 0 && long(end) !== 0x06054b50) end -= 1;
  if (end < 0) throw new Error("a damaged ZIP archive");
  const entries = [];
  for (let at = long(end + 16), left = short(end + 10); left > 0; left -= 1) {
    const names = short(at + 28), start = long(at + 42);
    const path = new TextDecoder().decode(new Uint8Array(view.buffer, at + 46, names)).split(/[/\\]/);
    const own = path.at(-1) && !path.some((part) => part.startsWith(".") || part === "__MACOSX");
    if (own) entries.push({ path, method: short(at + 10), locked: short(at + 8) & 1, size: long(at + 20), data: start + 30 + short(start + 26) + short(start + 28) });
    at += 46 + names + short(at + 30) + short(at + 32);
  }
  const first = entries[0]?.path.slice(0, -1) ?? [], differs = first.findIndex((name, k) => entries.some(({ path }) => path[k] !== name || path.length === k + 1));
  const shared = differs < 0 ? first.length : differs;
  return Promise.all(entries.map(async ({ path, method, locked, size, data }) => {
    if (locked || ![0, 8].includes(method)) throw new Error("a ZIP archive that is encrypted or packed in another way");
    const packed = archive.slice(data, data + size);
    const content = method ? await new Response(packed.stream().pipeThrough(new DecompressionStream("deflate-raw"))).blob() : packed;
    const name = path.slice(shared).join("_"), kind = TYPES[/[^.]*$/.exec(name.toLowerCase())[0]];
    return new File([content], name, kind ? { type: `image/${kind}` } : {});
  }));
}

const TYPES = { jpg: "jpeg", jpeg: "jpeg", png: "png", gif: "gif", webp: "webp", bmp: "bmp", avif: "avif", heic: "heic", heif: "heif", tif: "tiff", tiff: "tiff" }; // as a browser tells those of files
