from pathlib import Path

ROOT = Path(__file__).parents[2]
PLAN = ROOT / "resources" / "examples" / "plan.json"
STOREYS = PLAN.parent / "two_storeys" / "plan.json"
