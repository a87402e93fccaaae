# Snakemake runs this in a new environment of plan2scene.yaml, from the folder that it was started in.
python -m pip install --quiet --constraint constraints.txt --editable '.[formats,exports]'
