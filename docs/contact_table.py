"""Print the table of docs/contact.md: what the normal laws with hysteresis damping deliver.

Run it as `python docs/contact_table.py`.
"""

import warnings

import flexmb as fm

ASKED = (0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95)
LAWS = (
    fm.HuntCrossley,
    fm.contact.HerbertMcWhannell,
    fm.contact.LeeWang,
    fm.LankaraniNikravesh,
    fm.contact.Gonthier,
    fm.contact.ZhiyingQishao,
    fm.contact.Flores,
    fm.contact.HuGuo,
    fm.contact.CarvalhoMartins,
    fm.contact.ExactRestitution,
)


def main():
    print("| law | " + " | ".join(f"{e:g}" for e in ASKED) + " |")
    print("|" + "---|" * (len(ASKED) + 1))
    for kind in LAWS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fm.errors.RestitutionWarning)
            law = kind(stiffness=1.0)
        print(f"| `{kind.__name__}` | " + " | ".join(f"{law.delivered_restitution(e):.3f}" for e in ASKED) + " |")


if __name__ == "__main__":
    main()
