//! What boards are drawn with, here and in the tests of the command line.

/// The first 17 markers of OpenCV's DICT_6X6_250, row by row from the highest bit, white is 1.
pub const MARKERS: [u64; 17] = [
    0x1_e3dd_82a6,
    0x0_efba_3891,
    0x1_5907_eacd,
    0xc_91b3_069e,
    0xd_607d_6e15,
    0xd_8e8e_0e68,
    0x4_268b_41f5,
    0x8_8a50_f29a,
    0x3_07d5_24fd,
    0x3_c2f3_4b3c,
    0x4_5dfc_74e3,
    0x4_8d85_b257,
    0x7_1055_8fc6,
    0x8_6dcf_ad07,
    0x8_d72a_93f6,
    0xa_2b89_dcde,
    0x0_9fd1_e9c4,
];
